// main() of every test: doctest, and RapidCheck with a seed that does not change from run to run.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdlib>

int main(int argc, char** argv) {
  setenv("RC_PARAMS", "seed=1", 0);  // one that is set already wins
  return doctest::Context(argc, argv).run();
}
