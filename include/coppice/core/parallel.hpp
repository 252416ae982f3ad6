// How core code asks its host for threads: it never starts one.
#pragma once

#include <concepts>
#include <cstddef>

namespace coppice {

/// Something that runs body(begin, end) over disjoint ranges which together cover [0, count), on any threads
/// and in any order, in pieces of about `grain`. Results must not depend on the pieces.
template <class E>
concept Executor = requires(const E& executor, void (*body)(std::size_t, std::size_t)) {
  executor(std::size_t{}, std::size_t{}, body);
};

/// The executor without threads.
struct Serial {
  template <class Body>
  void operator()(std::size_t count, std::size_t /*grain*/, Body&& body) const {
    if (count > 0) body(std::size_t{0}, count);
  }
};
static_assert(Executor<Serial>);

}  // namespace coppice
