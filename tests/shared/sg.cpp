// The stated errors of the forms of spherical Gaussians: float and Lanes against __float128 and long double
// at the same inputs, and against sums over the sphere. The rows are those of docs/sg_algebra.md.
#include <coppice/shared/sg.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <coppice/core/random.hpp>
#include <coppice/core/simd.hpp>
#include <coppice/reference/sg.hpp>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

using namespace coppice;
using real = long double;

namespace {

__extension__ typedef __float128 quad;
using quad3 = std::array<quad, 3>;

constexpr real pi_real = std::numbers::pi_v<real>;

/// 0 and 1e-8 to 1e10.
std::vector<float> sharpnesses(int a_decade) {
  std::vector<float> all{0};
  for (int i = -8 * a_decade; i <= 10 * a_decade; ++i)
    all.push_back(float(std::pow(10.0, double(i) / a_decade)));
  return all;
}

/// -1 to 1: both ends, 0, steps of 1/16, near 0 and ±1, and to 12 widths of the Gaussian about 0.
std::vector<float> cosines(float sharpness) {
  std::vector<float> all{0, 0.999f, 0.99999f, 0.99999994f};
  for (int i = 1; i <= 16; ++i) all.push_back(float(i) / 16);
  for (int i = 1; i <= 24; ++i) all.push_back(std::min(1.0f, 0.5f * float(i) / std::sqrt(sharpness + 1)));
  for (int i = 1; i <= 8; ++i) all.push_back(float(std::pow(10.0, -i)));
  const std::size_t count = all.size();
  for (std::size_t i = 0; i < count; ++i) all.push_back(-all[i]);
  return all;
}

quad root(quad x) {
  if (!(x > 0)) return 0;
  quad y = quad(std::sqrt(real(x)));
  for (int i = 0; i < 2; ++i) y = (y + x / y) / 2;
  return y;
}
quad dot_of(const quad3& a, const quad3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
quad3 unit(const vec3& v) {
  quad3 q{quad(v.x), quad(v.y), quad(v.z)};
  const quad size = root(dot_of(q, q));
  for (quad& c : q) c /= size;
  return q;
}

real exact_integral(real l) { return l > 0 ? -2 * pi_real * std::expm1(-2 * l) / l : 4 * pi_real; }

real exact_length(real l) {
  if (l > 0.05L) return 1 - 2 / -std::expm1(2 * l) - 1 / l;
  const real y = l * l;
  return l * (1 / 3.0L - y * (1 / 45.0L - y * (2 / 945.0L - y * (1 / 4725.0L - y * 2 / 93555.0L))));
}
real exact_shortfall(real l) { return l > 1 ? 1 / l + 2 / -std::expm1(2 * l) : 1 - exact_length(l); }

struct ExactProduct {
  quad3 resultant{};  ///< Σ λp
  quad size;          ///< of it
  quad sum = 0;       ///< Σ λ
  real integral() const { return std::exp(real(size - sum)) * exact_integral(real(size)); }
};

ExactProduct exact_product(std::initializer_list<SgShape> shapes) {
  ExactProduct product;
  for (const SgShape& g : shapes) {
    const quad3 axis = unit(g.axis);
    for (std::size_t i = 0; i < 3; ++i) product.resultant[i] += quad(g.sharpness) * axis[i];
    product.sum += quad(g.sharpness);
  }
  product.size = root(dot_of(product.resultant, product.resultant));
  return product;
}

reference::AbovePlane exact_above(float cosine, float sharpness) {
  const auto tail = reference::RingIntegral(std::abs(real(cosine)), real(sharpness))();
  if (cosine <= 0) return tail;
  const real all = exact_integral(real(sharpness));
  return {all - tail.integral, all * exact_length(real(sharpness)) * real(cosine) + tail.cosine};
}

float first(Lanes x) {
  std::array<float, Lanes::width> all;
  x.store(all.data());
  return all[0];
}

/// The worst relative error where the exact value is at least `floor`; infinite once a value is NaN,
/// infinite, or above twice the floor where the exact value is below it.
struct Worst {
  real error = 0;
  real floor = 1e-30L;

  void look(float value, real exact) {
    if (!std::isfinite(value))
      error = INFINITY;
    else if (std::abs(exact) >= floor)
      error = std::max(error, std::abs(value / exact - 1));
    else if (exact != 0 || floor > 0)
      error = std::max(error, std::abs(value) <= 20 * floor ? 0.0L : real(INFINITY));
    else if (value != 0)
      error = INFINITY;
  }
  /// The error of a value that may be near 0, in units of `of`.
  void look(float value, real exact, real of) {
    error = std::isfinite(value) ? std::max(error, std::abs(value - exact) / of) : real(INFINITY);
  }
};

void report(const std::string& form, const Worst& worst, double limit) {
  INFO(form);
  MESSAGE("| " << form << " | " << double(worst.error) << " | " << limit << " |");
  CHECK(double(worst.error) <= limit);
}

/// A form of λ alone, by float and Lanes.
template <class Form, class Exact>
void check_sharpness_form(const char* name, const Form& form, const Exact& exact, double limit) {
  Worst worst;
  for (const float l : sharpnesses(32)) {
    worst.look(form(l), exact(real(l)));
    worst.look(first(form(Lanes(l))), exact(real(l)));
  }
  report(name, worst, limit);
}

vec3 turned(const vec3& direction, double angle, Random& random) {
  vec3 u, v;
  make_frame(direction, u, v);
  const float turn = 2 * pi * random.uniform();
  const vec3 across = u * std::cos(turn) + v * std::sin(turn);
  return normalize(direction * float(std::cos(angle)) + across * float(std::sin(angle)));
}

/// Angles at which Gaussians of these sharpnesses still meet, and those of right, opposed and random axes.
std::vector<double> angles(float a, float b, Random& random) {
  const double width = a > 0 && b > 0 ? std::sqrt(1 / double(a) + 1 / double(b)) : 1;
  std::vector<double> all{0, 0.5 * std::numbers::pi, std::numbers::pi, 3 * double(random.uniform())};
  for (const double x : {0.1, 0.5, 2.0, 6.0, 10.0}) all.push_back(std::min(x * width, std::numbers::pi));
  return all;
}

/// Pairs of Gaussians of all sharpnesses at all those angles.
template <class Function>
void for_pairs(int a_decade, const Function& f) {
  Random random(7);
  for (const float la : sharpnesses(a_decade))
    for (const float lb : sharpnesses(a_decade))
      for (const double angle : angles(la, lb, random)) {
        const vec3 axis = normalize(random.direction());
        f(SgShape{axis, la}, SgShape{turned(axis, angle, random), lb});
      }
}

constexpr real lanes_floor = 2e-29L;  // Lanes end at e^-69 of a factor of at most 4π

}  // namespace

static_assert(sizeof(SgShape) == 16 && offsetof(SgShape, sharpness) == 12);
static_assert(sizeof(SgLight) == 32 && offsetof(SgLight, amplitude) == 16);

TEST_CASE("the rings that other tests trust agree with what is known at 0 and -1") {
  for (const float sharpness : sharpnesses(2)) {
    const real l = real(sharpness), all = exact_integral(l);
    CHECK(std::abs(reference::RingIntegral(0, l)().integral / all - 0.5L) < 1e-14L);
    if (l < 1e-3L) continue;
    if (l < 500)
      CHECK(std::abs(reference::RingIntegral(0, l)().cosine * l * std::exp(l) /
                         (2 * pi_real * std::cyl_bessel_i(1.0L, l)) -
                     1) < 1e-13L);
    if (l > 1000) continue;
    const auto below = reference::RingIntegral(1, l)();
    const real decay = std::exp(-l);
    CHECK(std::abs(below.integral / all * (1 + decay) / decay - 1) < 1e-14L);
    if (l > 0.1L)
      CHECK(std::abs(below.cosine / (2 * pi_real * decay * (1 - decay - l * decay)) * l * l - 1) < 1e-13L);
  }
}

TEST_CASE("the integral, the mean length and its shortfall of a Gaussian keep their stated errors") {
  check_sharpness_form(
      "integral", [](auto l) { return sg_integral(l); }, exact_integral, 5e-7);
  check_sharpness_form(
      "normalisation", [](auto l) { return sg_normalisation(l); },
      [](real l) { return 1 / exact_integral(l); }, 5e-7);
  check_sharpness_form(
      "mean length", [](auto l) { return sg_mean_length(l); }, exact_length, 5e-7);
  check_sharpness_form(
      "1 - mean length", [](auto l) { return sg_mean_shortfall(l); }, exact_shortfall, 5e-7);
}

TEST_CASE("the value of a Gaussian keeps its stated error") {
  Worst worst, lanes;
  lanes.floor = lanes_floor;
  Random random(2);
  for (const float l : sharpnesses(8))
    for (const double angle : angles(l, l, random)) {
      const SgShape g{normalize(random.direction()), l};
      const vec3 d = turned(g.axis, angle, random);
      const real exact = std::exp(real(quad(l) * (dot_of(unit(g.axis), unit(d)) - 1)));
      worst.look(sg_evaluate(g, d), exact);
      lanes.look(first(sg_evaluate(Lanes(g.axis.x), Lanes(g.axis.y), Lanes(g.axis.z), Lanes(l), d)), exact);
    }
  worst.error = std::max(worst.error, lanes.error);
  report("value", worst, 1e-5);
}

TEST_CASE("the product of two Gaussians keeps its stated errors") {
  Worst scale, sharpness, axis;
  for_pairs(4, [&](const SgShape& a, const SgShape& b) {
    const SgProduct product = sg_product(a, b);
    const ExactProduct exact = exact_product({a, b});
    scale.look(product.scale, std::exp(real(exact.size - exact.sum)));
    if (exact.sum > 0) sharpness.look(product.sharpness, real(exact.size), real(exact.sum));
    for (int i = 0; i < 3; ++i) {
      const std::size_t at = std::size_t(i);
      if (exact.size > 0)
        axis.look(product.axis[i], real(exact.resultant[at] / exact.size), real(exact.sum / exact.size));
    }
  });
  report("product: scale", scale, 2e-5);
  report("product: sharpness, of Σλ", sharpness, 3e-7);
  report("product: axis, absolute, times Σλ/λ'", axis, 5e-7);
}

TEST_CASE("the inner product of two Gaussians keeps its stated error") {
  Worst worst, lanes;
  lanes.floor = lanes_floor;
  for_pairs(4, [&](const SgShape& a, const SgShape& b) {
    const real exact = exact_product({a, b}).integral();
    worst.look(sg_inner_product(a, b), exact);
    lanes.look(
        first(sg_inner_product(Lanes(a.axis.x), Lanes(a.axis.y), Lanes(a.axis.z), Lanes(a.sharpness), b)),
        exact);
  });
  worst.error = std::max(worst.error, lanes.error);
  report("inner product", worst, 2e-5);
}

TEST_CASE("the triple product of Gaussians keeps its stated error") {
  Worst worst, lanes;
  lanes.floor = lanes_floor;
  Random random(5);
  for_pairs(1, [&](const SgShape& a, const SgShape& b) {
    for (const float l : sharpnesses(1))
      for (const double angle : angles(l, std::max(a.sharpness, b.sharpness), random)) {
        const SgShape c{turned(a.axis, angle, random), l};
        const real exact = exact_product({a, b, c}).integral();
        worst.look(sg_triple_product(a, b, c), exact);
        const Lanes x = a.axis.x, y = a.axis.y, z = a.axis.z;
        lanes.look(first(sg_triple_product(x, y, z, Lanes(a.sharpness), b, c)), exact);
      }
  });
  worst.error = std::max(worst.error, lanes.error);
  report("triple product", worst, 2e-5);
}

TEST_CASE("the sharpness of a mean length keeps its stated error at both ends") {
  Worst worst;
  for (const float l : sharpnesses(32))
    worst.look(sg_sharpness_of_mean(float(exact_length(real(l))), float(exact_shortfall(real(l)))), real(l));
  report("sharpness of a mean", worst, 1e-6);
}

TEST_CASE("moments of directions give the Gaussian back, from all directions to a single one") {
  Worst worst, plain;
  Random random(9);
  for (const float l : sharpnesses(8)) {
    const vec3 axis = normalize(random.direction());
    const real length = exact_length(real(l)), shortfall = exact_shortfall(real(l));
    const vec3 mean = axis * float(length);
    const SgShape g = sg_from_moments(mean, float(shortfall * (1 + length)));
    worst.look(g.sharpness, std::min(real(l), 1e7L));
    if (l > 0) CHECK(dot(g.axis, axis) > 0.999999f);
    if (l <= 1e5f) plain.look(sg_from_moments(mean).sharpness, real(l), real(l) * (1 + real(l)) + 1e-30L);
  }
  report("sharpness from moments", worst, 1e-6);
  report("sharpness from the mean alone, over 1 + λ", plain, 3e-7);
  CHECK(sg_from_moments(vec3(0), 1).sharpness == 0);
  CHECK(sg_from_moments(vec3(0, 0, 1), 0).sharpness == doctest::Approx(1e7));
  CHECK(length(sg_from_moments(vec3(0), 1).axis) == 1);
}

TEST_CASE("the mean and the variance of a set of directions give the sharpness that they were drawn with") {
  Random random(11);
  for (const double l : {0.3, 3.0, 40.0, 1e4}) {
    glm::dvec3 sum(0);
    std::vector<glm::dvec3> drawn;
    for (int i = 0; i < 40000; ++i) {
      const double depth = -std::log1p(double(random.uniform()) * std::expm1(-2 * l)) / l;
      const double turn = 2 * std::numbers::pi * double(random.uniform()), r = std::sqrt(depth * (2 - depth));
      drawn.push_back({r * std::cos(turn), 1 - depth, r * std::sin(turn)});
      sum += drawn.back();
    }
    const glm::dvec3 mean = sum / double(drawn.size());
    double variance = 0;
    for (const glm::dvec3& d : drawn) variance += glm::dot(d - mean, d - mean) / double(drawn.size());
    CHECK(sg_from_moments(vec3(mean), float(variance)).sharpness == doctest::Approx(l).epsilon(0.05));
  }
}

TEST_CASE("a convolution keeps the integral and the mean length; its shape is as far off as stated") {
  Worst integral, length, shortfall;
  real anywhere = 0, sharp = 0, wide = 0;
  for (const float la : sharpnesses(2))
    for (const float lb : sharpnesses(2)) {
      const SgShape a{vec3(0, 0, 1), la};
      const SgProduct c = sg_convolution(a, lb);
      const real exact = exact_integral(real(la)) * exact_integral(real(lb));
      integral.look(float(real(c.scale) * exact_integral(real(c.sharpness)) / exact), 1);
      const real A = exact_length(real(la)), B = exact_length(real(lb));
      if (A * B > 1e-15L) length.look(float(exact_length(real(c.sharpness)) / (A * B)), 1);
      const real q = exact_shortfall(real(la)) + A * exact_shortfall(real(lb));
      shortfall.look(float(exact_shortfall(real(c.sharpness)) / q), 1);
      const real peak = real(sg_inner_product(a, {a.axis, lb}));
      for (int i = 0; i <= 64; ++i) {
        const double angle = std::min(std::numbers::pi, 6 * i / 64.0 / std::sqrt(double(c.sharpness) + 1e-9));
        const vec3 d(float(std::sin(angle)), 0, float(std::cos(angle)));
        const real off = std::abs(real(c.scale * sg_evaluate({c.axis, c.sharpness}, d)) -
                                  real(sg_inner_product(a, {d, lb}))) /
                         peak;
        anywhere = std::max(anywhere, off);
        if (la >= 100 || lb >= 100) sharp = std::max(sharp, off);
        if (la <= 0.1f || lb <= 0.1f) wide = std::max(wide, off);
      }
    }
  report("convolution: integral", integral, 1e-6);
  report("convolution: mean length", length, 1e-6);
  report("convolution: 1 - mean length", shortfall, 1e-6);
  report("convolution: shape, of the peak", {anywhere}, 0.095);
  report("convolution: shape, either λ ≥ 100", {sharp}, 0.01);
  report("convolution: shape, either λ ≤ 0.1", {wide}, 5e-4);
}

TEST_CASE("the clamped cosine and the share above a plane keep their stated errors") {
  Worst cosine, share, cosine_fast, share_fast;
  for (const float l : sharpnesses(4))
    for (const float c : cosines(l)) {
      const auto exact = exact_above(c, l);
      const real all = exact_integral(real(l));
      cosine.look(sg_clamped_cosine(c, l), exact.cosine);
      share.look(sg_hemisphere_share(c, l), exact.integral / all);
      cosine_fast.look(sg_mean_cosine_fast(c, l), exact.cosine / all, 1);
      cosine_fast.look(first(sg_mean_cosine_fast(Lanes(c), Lanes(l))), exact.cosine / all, 1);
      share_fast.look(sg_hemisphere_share_fast(c, l), exact.integral / all, 1);
      share_fast.look(first(sg_hemisphere_share_fast(Lanes(c), Lanes(l))), exact.integral / all, 1);
    }
  report("clamped cosine", cosine, 1e-5);
  report("share above a plane", share, 1e-5);
  report("clamped cosine, fast, of the integral", cosine_fast, 3e-4);
  report("share above a plane, fast", share_fast, 4e-4);
}

TEST_CASE("the fast clamped cosine splits as the exact one does: F(c) - F(-c) = A c") {
  for (const float l : sharpnesses(4))
    for (const float c : cosines(l))
      CHECK(std::abs(sg_mean_cosine_fast(c, l) - sg_mean_cosine_fast(-c, l) - sg_mean_length(l) * c) < 2e-7f);
}

TEST_CASE("a cone and its Gaussian keep their stated errors, and every Gaussian has a cone") {
  const real ln2 = std::numbers::ln2_v<real>;
  Worst angle, back, sharpness;
  std::vector<float> all = sharpnesses(32);
  for (int i = -40; i <= 40; ++i) all.push_back(float(0.5L * ln2) * (1 + float(i) * 5.9604645e-8f));
  for (const float l : all) {
    const real x = 0.5L * ln2 / real(l);
    angle.look(sg_cone_angle(l), x < 1 ? 2 * std::asin(std::sqrt(x)) : pi_real);
    if (x < 1) back.look(sg_cone_sharpness(sg_cone_angle(l)), real(l));
  }
  for (int i = 0; i <= 400; ++i) {
    const float a = pi * float(std::pow(10.0, -5.0 * i / 400));
    const real s = std::sin(0.5L * real(a));
    sharpness.look(sg_cone_sharpness(a), std::min(0.5L * ln2 / (s * s), 1e10L));
  }
  report("cone of a Gaussian", angle, 5e-7);
  report("Gaussian of a cone", sharpness, 1e-6);
  report("there and back", back, 2e-6);
  CHECK(sg_cone_sharpness(0) == SG_MAX_SHARPNESS);
}

TEST_CASE("the closed forms agree with sums over the sphere") {
  Random random(13);
  const auto exact = [](const SgShape& g) {
    return reference::Gaussian{glm::normalize(glm::dvec3(g.axis)), double(g.sharpness)};
  };
  for (const float l : {0.0f, 0.7f, 5.0f, 60.0f, 3000.0f}) {
    const SgShape a{normalize(random.direction()), l}, b{turned(a.axis, 0.3, random), 4};
    const SgShape c{turned(a.axis, 1, random), 0.5f};
    const vec3 n = turned(a.axis, 1.4, random), below = turned(a.axis, 1.7, random);
    const auto near = [](float x, double y) { CHECK(double(x) == doctest::Approx(y).epsilon(3e-4)); };
    near(sg_triple_product(a, b, c), reference::sg_triple_product(exact(a), exact(b), exact(c)));
    near(sg_inner_product(a, {n, 9}), reference::sg_convolution(exact(a), 9, glm::normalize(glm::dvec3(n))));
    for (const vec3& normal : {n, below}) {
      const glm::dvec3 up = glm::normalize(glm::dvec3(normal));
      if (l > 100 && dot(normal, a.axis) < 0) continue;
      near(sg_clamped_cosine(dot(normal, a.axis), l), reference::sg_clamped_cosine(exact(a), up));
      const double all = double(sg_integral(l));
      CHECK(std::abs(double(sg_hemisphere_share(dot(normal, a.axis), l)) -
                     reference::sg_hemisphere(exact(a), up) / all) < 2e-3);
    }
  }
}
