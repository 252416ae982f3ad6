// Executors that cut their work differently: results must not tell.
#pragma once

#include <algorithm>
#include <coppice/core/parallel.hpp>
#include <thread>

namespace support {

/// Pieces of `size` from the last to the first, whatever grain is asked for.
struct Backwards {
  std::size_t size = 7;

  template <class Body>
  void operator()(std::size_t count, std::size_t, Body&& body) const {
    for (std::size_t end = count; end > 0; end -= std::min(end, size)) body(end - std::min(end, size), end);
  }
};
static_assert(coppice::Executor<Backwards>);

/// Two threads that take turns at pieces of a grain.
struct TwoThreads {
  template <class Body>
  void operator()(std::size_t count, std::size_t grain, Body&& body) const {
    const std::size_t step = std::max<std::size_t>(grain, 1);
    const auto every_other = [&](std::size_t first) {
      for (std::size_t begin = first * step; begin < count; begin += 2 * step)
        body(begin, std::min(begin + step, count));
    };
    std::thread other(every_other, 1);
    every_other(0);
    other.join();
  }
};
static_assert(coppice::Executor<TwoThreads>);

}  // namespace support
