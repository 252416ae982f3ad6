// The sum of what the invocations of a workgroup have, in the same order always.

shared vec3 group_parts[KERNEL_GROUP_SIZE];

// To be called once a kernel, by all invocations.
vec3 sum_of_group(vec3 part) {
  uint i = gl_LocalInvocationID.x;
  group_parts[i] = part;
  barrier();
  for (uint apart = KERNEL_GROUP_SIZE / 2u; apart > 0u; apart /= 2u) {
    if (i < apart) group_parts[i] += group_parts[i + apart];
    barrier();
  }
  return group_parts[0];
}
