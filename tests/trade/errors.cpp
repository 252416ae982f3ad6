// Image errors against their definitions, written out.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <coppice/core/random.hpp>
#include <coppice/trade/errors.hpp>
#include <limits>
#include <vector>

using namespace coppice;

namespace {

using Mask = std::vector<bool>;

Image random_image(Random& random, int width, int height) {
  Image image(width, height);
  for (auto& p : image.pixels)
    for (int c = 0; c < 3; ++c) p[c] = std::exp(8 * random.uniform() - 6);
  return image;
}

/// The definitions of the report, term by term, in long double.
ImageErrors by_definition(const Image& image, const Image& reference, const Mask& counts) {
  std::vector<long double> x, r;
  for (std::size_t i = 0; i < counts.size(); ++i)
    for (int c = 0; counts[i] && c < 3; ++c)
      x.push_back(image.pixels[i][c]), r.push_back(reference.pixels[i][c]);
  const auto n = static_cast<long double>(x.size());
  long double mean = 0, difference = 0, norm = 0, relative = 0, relative2 = 0;
  for (const auto v : r) mean += v / n;
  std::vector<long double> each;
  for (std::size_t i = 0; i < x.size(); ++i) {
    difference += (x[i] - r[i]) * (x[i] - r[i]);
    norm += r[i] * r[i];
    each.push_back(std::abs(x[i] - r[i]) / (r[i] + mean / 10));
    relative += each.back() / n;
    relative2 += (x[i] - r[i]) * (x[i] - r[i]) / (r[i] * r[i] + 0.01L) / n;
  }
  std::ranges::sort(each);
  const auto percentile = [&](double share) {
    return double(each[std::size_t(share * double(each.size() - 1))]);
  };
  return {double(std::sqrt(difference / norm)),
          double(relative),
          double(relative2),
          percentile(0.95),
          percentile(0.99),
          x.size() / 3};
}

void check_all_zero(const ImageErrors& e) {
  CHECK(e.rel_rmse == 0);
  CHECK(e.mre == 0);
  CHECK(e.rel_mse == 0);
  CHECK(e.p95 == 0);
  CHECK(e.p99 == 0);
}

}  // namespace

TEST_CASE("errors are those of their definitions, over the pixels that count") {
  Random random(1);
  for (const int size : {1, 3, 20, 100}) {
    CAPTURE(size);
    const Image image = random_image(random, size, size), reference = random_image(random, size, size);
    Mask counts(image.pixels.size());
    for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = i == 0 || random.uniform() < 0.7f;
    const ImageErrors e = image_errors(image, reference, counts),
                      expected = by_definition(image, reference, counts);
    CHECK(e.pixels == expected.pixels);
    CHECK(e.rel_rmse == doctest::Approx(expected.rel_rmse).epsilon(1e-9));
    CHECK(e.mre == doctest::Approx(expected.mre).epsilon(1e-9));
    CHECK(e.rel_mse == doctest::Approx(expected.rel_mse).epsilon(1e-9));
    CHECK(e.p95 == doctest::Approx(expected.p95).epsilon(1e-9));
    CHECK(e.p99 == doctest::Approx(expected.p99).epsilon(1e-9));
  }
}

TEST_CASE("a grey image that is a tenth too bright errs by a tenth") {
  const Image reference(4, 4, vec3(1)), image(4, 4, vec3(1.1f));
  const ImageErrors e = image_errors(image, reference, Mask(16, true));
  CHECK(e.rel_rmse == doctest::Approx(0.1).epsilon(1e-6));
  CHECK(e.mre == doctest::Approx(0.1 / 1.1).epsilon(1e-6));
  CHECK(e.rel_mse == doctest::Approx(0.01 / 1.01).epsilon(1e-6));
  CHECK(e.p99 == doctest::Approx(0.1 / 1.1).epsilon(1e-6));
  CHECK(e.pixels == 16);
}

TEST_CASE("one bright miss among many rules rel_rmse, not mre or p99") {
  Image reference(100, 10, vec3(1));
  reference.at(50, 5) = vec3(1000);
  Image image = reference;
  image.at(50, 5) = vec3(500);
  const ImageErrors e = image_errors(image, reference, Mask(1000, true));
  CHECK(e.rel_rmse > 0.49);
  CHECK(e.mre < 0.001);
  CHECK(e.p99 == 0);
}

TEST_CASE("p99 is passed by a hundredth of the values") {
  const Image reference(1000, 1, vec3(1));
  Image image = reference;
  for (int x = 0; x < 12; ++x) image.at(x, 0) = vec3(3);
  CHECK(image_errors(image, reference, Mask(1000, true)).p99 == doctest::Approx(2 / 1.1));
  CHECK(image_errors(image, reference, Mask(1000, true)).p95 == 0);
  for (int x = 8; x < 12; ++x) image.at(x, 0) = vec3(1);
  CHECK(image_errors(image, reference, Mask(1000, true)).p99 == 0);
}

TEST_CASE("an image is its own reference without error") {
  Random random(2);
  const Image image = random_image(random, 30, 20);
  const ImageErrors e = image_errors(image, image, Mask(600, true));
  check_all_zero(e);
  CHECK(e.pixels == 600);
}

TEST_CASE("no pixels, or none that count, have no error") {
  CHECK(image_errors(Image(), Image(), Mask()).pixels == 0);
  check_all_zero(image_errors(Image(), Image(), Mask()));
  const ImageErrors e = image_errors(Image(2, 2, vec3(1)), Image(2, 2, vec3(2)), Mask(4, false));
  CHECK(e.pixels == 0);
  check_all_zero(e);
}

TEST_CASE("pixels that do not count may hold anything") {
  Random random(3);
  Image image = random_image(random, 4, 4), reference = random_image(random, 4, 4);
  Mask counts(16, true);
  counts[5] = counts[9] = false;
  const ImageErrors before = image_errors(image, reference, counts);
  image.pixels[5] = vec3(std::numeric_limits<float>::quiet_NaN());
  reference.pixels[9] = vec3(std::numeric_limits<float>::infinity());
  const ImageErrors after = image_errors(image, reference, counts);
  CHECK(after.rel_rmse == before.rel_rmse);
  CHECK(after.mre == before.mre);
  CHECK(after.rel_mse == before.rel_mse);
  CHECK(after.p99 == before.p99);
}

TEST_CASE("a black reference: met exactly without error, missed with infinite rel_rmse and no NaN") {
  const Image black(4, 4);
  check_all_zero(image_errors(black, black, Mask(16, true)));
  const ImageErrors e = image_errors(Image(4, 4, vec3(0.5f)), black, Mask(16, true));
  CHECK(std::isinf(e.rel_rmse));
  CHECK_FALSE(std::isnan(e.mre));
  CHECK(e.rel_mse == doctest::Approx(25));
  CHECK_FALSE(std::isnan(e.p99));
}

TEST_CASE("images of 1e30 have finite errors") {
  const ImageErrors e = image_errors(Image(8, 8, vec3(2e30f)), Image(8, 8, vec3(1e30f)), Mask(64, true));
  CHECK(e.rel_rmse == doctest::Approx(1));
  CHECK(e.mre == doctest::Approx(1 / 1.1));
  CHECK(e.rel_mse == doctest::Approx(1));
}

TEST_CASE("block means average the pixels that count, in blocks of which more than half count") {
  Image image(5, 4, vec3(100));  // the fifth column fills no block
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) image.at(x, y) = vec3(x, y, 1);
  Mask counts(20, true), block_counts;
  counts[image.index(3, 1)] = false;                              // three of four
  counts[image.index(0, 2)] = counts[image.index(1, 3)] = false;  // two of four
  const Image means = block_means(image, counts, 2, block_counts);
  REQUIRE(means.width == 2);
  REQUIRE(means.height == 2);
  CHECK(block_counts == Mask{true, true, false, true});
  CHECK(means.at(0, 0) == vec3(0.5f, 0.5f, 1));
  CHECK(length(means.at(1, 0) - vec3(7 / 3.0f, 1 / 3.0f, 1)) < 1e-6f);
  CHECK(means.at(1, 1) == vec3(2.5f, 2.5f, 1));
}

TEST_CASE("blocks of one pixel are the image, blocks larger than it are none") {
  Random random(4);
  const Image image = random_image(random, 3, 2);
  Mask block_counts;
  CHECK(block_means(image, Mask(6, true), 1, block_counts).pixels == image.pixels);
  CHECK(block_counts == Mask(6, true));
  CHECK(block_means(image, Mask(6, true), 4, block_counts).pixels.empty());
  CHECK(block_counts.empty());
}

TEST_CASE("block means quiet the noise that single pixels have") {
  Random random(5);
  const Image reference(64, 64, vec3(1));
  Image noisy = reference;
  for (auto& p : noisy.pixels) p += vec3(random.uniform() - 0.5f);
  Mask counts;
  const Mask all(64 * 64, true);
  const Image a = block_means(noisy, all, 8, counts), b = block_means(reference, all, 8, counts);
  CHECK(image_errors(a, b, counts).rel_rmse < 0.2 * image_errors(noisy, reference, all).rel_rmse);
}
