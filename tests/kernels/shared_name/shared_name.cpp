// Breaks the rule that scripts/check_instructions.py keeps: an inline function, compiled for AVX2, whose name
// says nothing of it.
#pragma GCC target("avx2")

namespace coppice_test {

struct Eight {
  float values[8];
};

[[gnu::noinline]] inline Eight twice_under_a_shared_name(const Eight& x) {
  typedef float Register __attribute__((vector_size(32)));
  Eight result;
  Register values;
  __builtin_memcpy(&values, &x, sizeof values);
  values += values;
  __builtin_memcpy(&result, &values, sizeof values);
  return result;
}

Eight use(const Eight& x);
Eight use(const Eight& x) { return twice_under_a_shared_name(x); }

}  // namespace coppice_test
