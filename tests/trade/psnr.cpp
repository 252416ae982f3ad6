// Peak signal-to-noise ratio against its definition.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/trade/psnr.hpp>

using namespace coppice;

TEST_CASE("the ratio is that of its definition, over the pixels that count") {
  Random random(1);
  for (const int size : {1, 3, 40}) {
    Image image(size, size), reference(size, size);
    std::vector<bool> counts(image.pixels.size());
    long double sum = 0, values = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      counts[i] = i == 0 || random.uniform() < 0.6f;
      for (int c = 0; c < 3; ++c) {
        image.pixels[i][c] = random.uniform();
        reference.pixels[i][c] = random.uniform();
        const long double d = static_cast<long double>(image.pixels[i][c]) - reference.pixels[i][c];
        if (counts[i]) sum += d * d, values += 1;
      }
    }
    CHECK(psnr(image, reference, counts) == doctest::Approx(double(10 * std::log10(values / sum))));
    CHECK(psnr(reference, image, counts) == psnr(image, reference, counts));
  }
}

TEST_CASE("known ratios: white against black, a tenth everywhere, one channel of one pixel") {
  const std::vector<bool> all(100, true);
  CHECK(psnr(Image(10, 10, vec3(1)), Image(10, 10), all) == 0);
  CHECK(psnr(Image(10, 10, vec3(0.6f)), Image(10, 10, vec3(0.5f)), all) == doctest::Approx(20));
  Image one(10, 10);
  one.at(3, 4).y = 1;
  CHECK(psnr(one, Image(10, 10), all) == doctest::Approx(10 * std::log10(300.0)));
}

TEST_CASE("what does not count does not matter; equal images have no noise; NaN stays") {
  Image image(2, 1, vec3(0.25f));
  const Image reference = image;
  CHECK(psnr(image, reference, {true, true}) == std::numeric_limits<double>::infinity());
  image.at(1, 0) = vec3(std::numeric_limits<float>::quiet_NaN());
  CHECK(psnr(image, reference, {true, false}) == std::numeric_limits<double>::infinity());
  CHECK(std::isnan(psnr(image, reference, {true, true})));
  CHECK(psnr(image, reference, {false, false}) == std::numeric_limits<double>::infinity());
}
