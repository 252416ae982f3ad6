#include <doctest/doctest.h>

#include <atomic>
#include <coppice/embree/threads.hpp>
#include <stdexcept>
#include <vector>

using coppice::Threads;

TEST_CASE("Threads visits each index exactly once") {
  for (const int thread_count : {1, 2}) {
    const Threads threads(thread_count);
    for (const std::size_t count : {0, 1, 2, 7, 1000, 4099}) {
      for (const std::size_t grain : {0, 1, 16, 5000}) {
        CAPTURE(count);
        CAPTURE(grain);
        std::vector<std::atomic<int>> visits(count);
        threads(count, grain, [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) visits[i]++;
        });
        std::size_t wrong = 0;
        for (const auto& visit : visits) wrong += visit != 1;
        CHECK(wrong == 0);
      }
    }
  }
}

TEST_CASE("Threads never calls the body for an empty loop or with an empty range") {
  const Threads threads(2);
  std::atomic<int> calls = 0, empty_ranges = 0;
  const auto body = [&](std::size_t begin, std::size_t end) {
    calls++;
    if (begin >= end) empty_ranges++;
  };
  threads(0, 1, body);
  CHECK(calls == 0);
  threads(100, 1, body);
  CHECK(calls > 0);
  CHECK(empty_ranges == 0);
}

TEST_CASE("Threads keeps to the number of threads it was given") {
  CHECK(Threads(1).count() == 1);
  CHECK(Threads(2).count() == 2);
  CHECK(Threads().count() >= 1);
  const Threads threads(2);
  std::atomic<bool> too_many = false;
  threads(1000, 1, [&](std::size_t, std::size_t) {
    const int slot = tbb::this_task_arena::current_thread_index();
    if (slot < 0 || slot >= 2) too_many = true;
  });
  CHECK_FALSE(too_many);
}

TEST_CASE("An exception in the body reaches the caller of Threads and leaves it usable") {
  const Threads threads(2);
  const auto failing = [](std::size_t begin, std::size_t end) {
    if (begin <= 500 && 500 < end) throw std::runtime_error("index 500");
  };
  CHECK_THROWS_WITH_AS(threads(1000, 1, failing), "index 500", std::runtime_error);
  std::atomic<std::size_t> visited = 0;
  threads(1000, 10, [&](std::size_t begin, std::size_t end) { visited += end - begin; });
  CHECK(visited == 1000);
}

TEST_CASE("Loops of Threads may nest") {
  const Threads threads(2);
  std::atomic<int> visits = 0;
  threads(8, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      threads(50, 4, [&](std::size_t inner_begin, std::size_t inner_end) {
        visits += int(inner_end - inner_begin);
      });
  });
  CHECK(visits == 400);
}
