// Which instruction sets there are, and what they are called.
#include <doctest/doctest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <coppice/kernels/kernels.hpp>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#if defined(__unix__) && !defined(NDEBUG)
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#endif

using namespace coppice;

namespace {

/// While it lives, the processor seems to have these of Highway's targets only.
class Pretend {
 public:
  explicit Pretend(std::int64_t targets) { hwy::SetSupportedTargetsForTest(targets); }
  ~Pretend() { hwy::SetSupportedTargetsForTest(0); }
  Pretend(const Pretend&) = delete;
  Pretend& operator=(const Pretend&) = delete;
};

std::size_t supported_count() { return supported_instruction_sets().size(); }

}  // namespace

TEST_CASE("instruction sets are named as the programs' options name them") {
  CHECK(std::string_view(name(InstructionSet::baseline)) == "baseline");
  CHECK(std::string_view(name(InstructionSet::avx2)) == "avx2");
  CHECK(std::string_view(name(InstructionSet::avx512)) == "avx512");
}

TEST_CASE("the supported sets begin with the baseline and rise to the best") {
  const auto sets = supported_instruction_sets();
  REQUIRE(!sets.empty());
  CHECK(sets.front() == InstructionSet::baseline);
  CHECK(std::ranges::is_sorted(sets));
  CHECK(&best_kernels<std::uint8_t>() == &kernels_for<std::uint8_t>(sets.back()));
  CHECK(&best_kernels<std::uint16_t>() == &kernels_for<std::uint16_t>(sets.back()));
}

TEST_CASE("a better set has wider registers, and Highway's name for it") {
  const auto sets = supported_instruction_sets();
  for (const InstructionSet set : sets) {
    const auto& kernels = kernels_for<std::uint8_t>(set);
    CHECK(kernels.width == kernels_for<std::uint16_t>(set).width);
    if (set == InstructionSet::avx2) {
      CHECK(kernels.width == 8);
      CHECK(std::string_view(kernels.instructions) == "AVX2");
    }
    if (set == InstructionSet::avx512) {
      CHECK(kernels.width == 16);
      CHECK(std::string_view(kernels.instructions) == "AVX3");
    }
  }
}

#if HWY_ARCH_X86
TEST_CASE("a processor gets the sets that it has, and no more") {
  const std::size_t here = supported_count();
  const Pretend none(HWY_SCALAR | HWY_SSE4);
  CHECK(supported_count() == 1);
  CHECK(&best_kernels<std::uint8_t>() == &kernels_for<std::uint8_t>(InstructionSet::baseline));
  const Pretend avx2(HWY_SCALAR | HWY_SSE4 | HWY_AVX2);
  CHECK(supported_count() == std::min<std::size_t>(here, 2));
}

#if defined(__unix__) && !defined(NDEBUG)
TEST_CASE("kernels that the processor does not have are refused by an assert") {
  const Pretend none(HWY_SCALAR);
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGABRT, SIG_DFL);
    std::fclose(stderr);
    kernels_for<std::uint8_t>(InstructionSet::avx2);
    std::_Exit(0);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK((WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT));
}
#endif
#endif
