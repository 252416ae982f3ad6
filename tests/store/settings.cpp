// Why a store is not used again; and the fingerprint of what it was made from.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/store/fingerprint.hpp>
#include <coppice/store/settings.hpp>
#include <set>

using namespace coppice;

TEST_CASE("the first difference of settings is a sentence") {
  const Settings stored{{"scene", "abc"}, {"sigma", "2"}, {"seed", "0"}};
  CHECK(first_difference(stored, stored) == "");
  CHECK(first_difference(stored, {{"seed", "0"}, {"sigma", "2"}, {"scene", "abc"}}) == "");
  CHECK(first_difference(stored, {{"scene", "abc"}, {"sigma", "3"}, {"seed", "1"}}) ==
        "was made with sigma 2, now it is 3");
  CHECK(first_difference(stored, {{"scene", "abc"}, {"sigma", "2"}}) ==
        "was made with seed 0, now there is none");
  CHECK(first_difference({}, stored) == "was made without scene, now it is abc");
  CHECK(first_difference({{"a", "1\n2"}}, {{"a", "3"}}) == "was made with a 1?2, now it is 3");
}

TEST_CASE("fingerprints tell any change of bytes, of order and of lengths") {
  std::vector<std::uint8_t> data(100);
  std::set<std::string> texts{Fingerprint().text(), Fingerprint().add_values<std::uint8_t>(data).text()};
  for (auto& byte : data)
    for (int bit = 0; bit < 8; ++bit) {
      byte = std::uint8_t(byte ^ (1 << bit));
      texts.insert(Fingerprint().add_values<std::uint8_t>(data).text());
      byte = std::uint8_t(byte ^ (1 << bit));
    }
  CHECK(texts.size() == 2 + 800);
  for (std::size_t length = 0; length < 100; ++length)
    texts.insert(Fingerprint().add_values<std::uint8_t>(std::span(data).first(length)).text());
  CHECK(texts.size() == 2 + 800 + 100);
  const std::vector<float> a{1, 2}, b{3}, c{1}, d{2, 3};
  CHECK(Fingerprint().add_values<float>(a).add_values<float>(b).text() !=
        Fingerprint().add_values<float>(c).add_values<float>(d).text());
  CHECK(Fingerprint().add_values<float>(a).text() == Fingerprint().add_values<float>(a).text());
  CHECK(Fingerprint().text().size() == 32);
}

TEST_CASE("fingerprints of random data differ in half of their bits") {
  Random random(1);
  double differing = 0;
  constexpr int trials = 500;
  for (int i = 0; i < trials; ++i) {
    std::vector<std::uint64_t> data{random.bits(), random.bits(), random.bits()};
    const std::string before = Fingerprint().add_values<std::uint64_t>(data).text();
    data[random.below(3)] ^= std::uint64_t{1} << random.below(64);
    const std::string after = Fingerprint().add_values<std::uint64_t>(data).text();
    for (std::size_t k = 0; k < 32; ++k)
      differing += std::popcount(
          unsigned(std::stoi(before.substr(k, 1), nullptr, 16) ^ std::stoi(after.substr(k, 1), nullptr, 16)));
  }
  CHECK(std::abs(differing / trials - 64) < 2);
}
