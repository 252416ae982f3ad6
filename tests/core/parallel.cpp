// What an executor is: one body over ranges that cover the whole.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/core/parallel.hpp>
#include <utility>
#include <vector>

using namespace coppice;

namespace {

/// Runs pieces of `grain`, the last first.
struct Backwards {
  template <class Body>
  void operator()(std::size_t count, std::size_t grain, Body&& body) const {
    for (std::size_t pieces = (count + grain - 1) / grain; pieces-- > 0;)
      body(pieces * grain, std::min(count, (pieces + 1) * grain));
  }
};
static_assert(Executor<Backwards>);
static_assert(!Executor<int>);

template <Executor E>
std::vector<int> visits(const E& executor, std::size_t count) {
  std::vector<int> visited(count, 0);
  executor(count, 3, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) ++visited[i];
  });
  return visited;
}

}  // namespace

TEST_CASE("every executor visits each index once") {
  for (const std::size_t count : {0u, 1u, 3u, 10u}) {
    CHECK(visits(Serial{}, count) == std::vector<int>(count, 1));
    CHECK(visits(Backwards{}, count) == std::vector<int>(count, 1));
  }
}

TEST_CASE("the serial executor calls once with the whole range, and never for nothing") {
  std::vector<std::pair<std::size_t, std::size_t>> calls;
  const auto note = [&](std::size_t begin, std::size_t end) { calls.emplace_back(begin, end); };
  Serial{}(0, 1, note);
  CHECK(calls.empty());
  Serial{}(5, 1, note);
  REQUIRE(calls.size() == 1);
  CHECK(calls[0] == std::pair<std::size_t, std::size_t>(0, 5));
}
