// The error for bad input: one line that names the item, what is wrong, and what to do.
#include <doctest/doctest.h>

#include <coppice/core/error.hpp>

using namespace coppice;

TEST_CASE("an input error says item, problem and remedy in one line, and keeps them apart") {
  const InputError error("sky.exr", "no channel R", "store RGB");
  CHECK(std::string(error.what()) == "sky.exr: no channel R; store RGB");
  CHECK(error.item() == "sky.exr");
  CHECK(error.problem() == "no channel R");
  CHECK(error.remedy() == "store RGB");
}

TEST_CASE("an input error is caught as a runtime error") {
  CHECK_THROWS_AS(throw InputError("a", "b", "c"), std::runtime_error);
}
