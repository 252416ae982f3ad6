// What a point reflects of a node, and the sums of it that dispatches hand on. Who includes this has defined
// `parameters`.

VplShape shape_of(VplNode n) {
  return VplShape(n.position.x, n.position.y, n.position.z, n.variance, n.normal.x, n.normal.y, n.normal.z,
                  n.softening, n.lobe.x, n.lobe.y, n.lobe.z, n.exponent);
}

PointShape shape_of(GlossyPoint p) {
  return PointShape(p.position.x, p.position.y, p.position.z, p.exponent, p.normal.x, p.normal.y, p.normal.z,
                    p.mirror.x, p.mirror.y, p.mirror.z);
}

// A point, and what it has reflected so far.
struct Gathering {
  GlossyPoint point;
  PointShape shape;
  vec3 radiance;
  uint taken;
};

Gathering gathering_of(uint index) {
  Gathering gathering;
  gathering.point = parameters.gather.points.at[index];
  gathering.shape = shape_of(gathering.point);
  gathering.radiance = parameters.gather.radiance.at[index];
  gathering.taken = parameters.gather.taken.at[index];
  return gathering;
}

void add(inout Gathering gathering, VplNode n) {
  gathering.taken += 1u;
  VplShape node = shape_of(n);
  VplArrival arrival = vpl_arrival(node, gathering.shape);
  if (!(arrival.geometry > 0.0)) return;
  VplTerms terms = vpl_cluster_terms(node, gathering.shape, arrival);
  vec3 reflected = gathering.point.diffuse * terms.diffuse + gathering.point.specular * terms.specular;
  gathering.radiance += (n.specular * terms.lobe + n.diffuse) * reflected;
}

void store(Gathering gathering, uint index) {
  parameters.gather.radiance.at[index] = gathering.radiance;
  parameters.gather.taken.at[index] = gathering.taken;
}
