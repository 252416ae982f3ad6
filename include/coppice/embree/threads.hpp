// An Executor on oneTBB.
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <coppice/core/parallel.hpp>

namespace coppice {

/// Runs loops on `count` threads (0: as many as the machine has).
class Threads {
 public:
  explicit Threads(int count = 0) : arena_(count > 0 ? count : tbb::task_arena::automatic) {}

  int count() const { return arena_.max_concurrency(); }

  template <class Body>
  void operator()(std::size_t count, std::size_t grain, Body&& body) const {
    arena_.execute([&] {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain == 0 ? 1 : grain),
                        [&](const tbb::blocked_range<std::size_t>& r) { body(r.begin(), r.end()); });
    });
  }

 private:
  mutable tbb::task_arena arena_;
};
static_assert(Executor<Threads>);

}  // namespace coppice
