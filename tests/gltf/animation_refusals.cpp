// Animations that break the format.
#include <doctest/doctest.h>

#include <random>

#include "clip.hpp"

using namespace coppice;
using namespace gltf_test;

namespace {

bool is_one_line(const std::string& message) { return !message.empty() && !contains(message, "\n"); }

// The sliding square with some of its JSON replaced.
std::string altered(std::string_view from, std::string_view to) {
  std::string json = sliding(R"([{"mesh":0}])", 0).gltf();
  const std::size_t at = json.find(from);
  REQUIRE(at != std::string::npos);
  return json.replace(at, from.size(), to);
}

std::string complaint_of_track(const std::vector<float>& input, const std::string& path,
                               const std::vector<float>& output, const std::string& more = "") {
  Builder builder = square();
  Clip clip;
  const int first = times(builder, input);
  clip.add(0, path, first, path == "rotation" ? builder.vec4s(output) : builder.vec3s(output), more);
  builder.members = clip.json();
  CHECK(complaint_of(builder).empty());  // what is not played is not read
  return moving_complaint_of(builder.gltf());
}

// Loads with objects that keep their promises, or throws InputError of one line.
bool loads_or_refuses(const std::filesystem::path& file) {
  try {
    const Scene scene = load_gltf(file, moving);
    for (const MovingObject& object : scene.objects)
      for (const float time : {-1.0f, 0.0f, 0.3f, 0.9f, 1.7f, 1e30f}) {
        const RigidTransform transform = object.motion.at(time);
        const float size = glm::length(transform.rotation);
        if (!is_finite(transform.translation) || !(std::fabs(size - 1) < 1e-5f)) return false;
      }
    return true;
  } catch (const InputError& error) {
    return is_one_line(error.what());
  }
}

// Every kind of channel and interpolation, in a chain.
Builder everything() {
  Builder builder = square();
  Clip clip;
  const int input = times(builder, {0, 0.5f, 2});
  clip.add(0, "translation", input, builder.vec3s({0, 0, 0, 1, 2, 3, 4, 0, 0}), R"(,"interpolation":"STEP")");
  clip.add(0, "rotation", input, builder.vec4s({0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 0}));
  clip.add(0, "scale", input, builder.vec3s({2, 2, 2, 2, 2, 2, 2, 2, 2}));
  std::vector<float> spline(36);
  for (std::size_t i = 0; i < spline.size(); ++i) spline[i] = std::sin(float(i));
  const std::string cubic = R"(,"interpolation":"CUBICSPLINE")";
  clip.add(1, "rotation", input, builder.vec4s(spline), cubic);
  spline.resize(27);
  clip.add(1, "translation", input, builder.vec3s(spline), cubic);
  clip.add(2, "translation", input, builder.vec3s({1, 1, 1, 2, 2, 2, 3, 3, 3}));
  builder.nodes = R"([{"children":[1,2]},{"mesh":0,"scale":[1,-1,1]},{"mesh":0,"rotation":[0,0,0,1]}])";
  builder.members = clip.json();
  return builder;
}

}  // namespace

TEST_CASE("times that do not ascend, are negative, not finite, or absent are refused by name") {
  const std::vector<float> output(9, 1.0f);
  for (const float broken : {0.0f, 0.5f, -0.0f})
    CHECK(contains(complaint_of_track({0, 0.5f, broken}, "translation", output), "time 2 is not later"));
  for (const float broken : {-1.0f, INFINITY, NAN}) {
    const std::string message = complaint_of_track({0, broken, 2}, "translation", output);
    CHECK(contains(message, "animation 0, sampler 0, input: time 1 is negative or not finite"));
    CHECK(is_one_line(message));
  }
  CHECK_FALSE(complaint_of_track({}, "translation", {}).empty());
}

TEST_CASE("values that are not finite, no rotations, too far away, or of another number are refused") {
  const std::vector<float> input{0, 1};
  const std::string cubic = R"(,"interpolation":"CUBICSPLINE")";
  for (const float broken : {INFINITY, -INFINITY, NAN}) {
    CHECK(contains(complaint_of_track(input, "translation", {0, 0, 0, 0, broken, 0}), "output: element 1"));
    CHECK(
        contains(complaint_of_track(input, "rotation", {0, 0, 0, 1, 0, 0, 0, broken}), "output: element 1"));
    CHECK(contains(complaint_of_track(input, "scale", {1, 1, 1, 1, broken, 1}), "output: element 1"));
  }
  CHECK(contains(complaint_of_track(input, "rotation", {0, 0, 0, 1, 0, 0, 0, 0}), "rotation of key 1"));
  CHECK(contains(complaint_of_track(input, "translation", {0, 0, 0, 0, 2e9f, 0}), "node 0: its animation"));
  CHECK(contains(complaint_of_track(input, "translation",
                                    {0, 0, 0, 0, 1, 0, 2e9f, 0, 0, 0, 0, 0, 1, 1, 1, 0, 0, 0}, cubic),
                 "node 0: its animation"));
  CHECK(contains(complaint_of_track(input, "translation", {0, 0, 0}), "1 values do not match 2 times"));
  CHECK(
      contains(complaint_of_track(input, "translation", {0, 0, 0, 1, 1, 1}, cubic), "2 values do not match"));
  CHECK(complaint_of_track(input, "translation", {0, 0, 0, 1, 1, 1}).empty());
}

TEST_CASE("tracks may not take absent items, other types, two channels for one, or nodes with a matrix") {
  const auto complaint = [](std::string_view from, std::string_view to) {
    return moving_complaint_of(altered(from, to));
  };
  CHECK(contains(complaint(R"("sampler":0)", R"("sampler":7)"), "no sampler 7"));
  CHECK(contains(complaint(R"("sampler":0)", R"("sampler":-2)"), "no sampler -2"));
  CHECK_FALSE(complaint(R"("sampler":0,)", "").empty());
  CHECK(contains(complaint(R"("node":0)", R"("node":7)"), "no node 7"));
  CHECK(contains(complaint(R"("input":4)", R"("input":77)"), "no accessor 77"));
  CHECK(contains(complaint(R"("output":5)", R"("output":77)"), "no accessor 77"));
  CHECK(contains(complaint(R"("input":4)", R"("input":3)"), "its values must be floats"));
  CHECK(contains(complaint(R"("input":4)", R"("input":0)"), "another type"));
  CHECK(contains(complaint(R"("output":5)", R"("output":6)"), "another type"));
  CHECK(contains(complaint(R"("output":5)", R"("output":5,"interpolation":"QUINTIC")"), "QUINTIC"));
  CHECK(contains(complaint(R"("path":"rotation")", R"("path":"translation")"), "another type"));
  CHECK(contains(complaint(R"("sampler":1,"target":{"node":0,"path":"rotation")",
                           R"("sampler":0,"target":{"node":0,"path":"translation")"),
                 "node 0: two channels"));
  CHECK(
      contains(complaint(R"([{"mesh":0}])", R"([{"mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}])"),
               "node 0: it is animated and has a matrix"));
}

TEST_CASE("rotations of integers that are not normalised are refused") {
  Builder builder = square();
  Clip clip;
  const int input = times(builder, {0, 1});
  const std::vector<std::int16_t> values{0, 0, 0, 1, 0, 0, 1, 0};
  clip.add(0, "rotation", input, builder.add(values, 5122, 4, "VEC4"));
  builder.members = clip.json();
  CHECK(contains(moving_complaint_of(builder.gltf()), "normalised"));
}

TEST_CASE("keyframes that many nodes inherit are refused before memory runs out") {
  Builder builder = triangle();
  Clip clip;
  const int input = times(builder, {0, 1}), output = builder.vec3s({0, 0, 0, 1, 0, 0});
  builder.nodes = "[";
  for (int node = 0; node < 6000; ++node) {
    clip.add(node, "translation", input, output);
    builder.nodes += R"({"mesh":0,"children":[)" + std::to_string(node + 1) + "]},";
  }
  builder.nodes += "{}]";
  builder.members = clip.json();
  CHECK(contains(moving_complaint_of(builder.gltf()), "2^24 keyframes"));
}

TEST_CASE("an animated .glb cut at any length with its header put right loads or is refused") {
  const Folder folder;
  const Bytes whole = everything().glb();
  REQUIRE(load_gltf(folder.write("whole.glb", whole), moving).objects.size() == 2);
  for (std::size_t size = 12; size < whole.size(); ++size) {
    Bytes cut(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    for (std::size_t i = 0; i < 4; ++i) cut[8 + i] = std::uint8_t(size >> (8 * i));
    CAPTURE(size);
    CHECK(loads_or_refuses(folder.write("cut.glb", cut)));
  }
}

TEST_CASE("flipped bits of an animated file load or are refused") {
  const Folder folder;
  const Bytes whole = everything().glb();
  const std::string text = everything().gltf();
  std::mt19937 random(20240608);
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes = round % 2 ? whole : Bytes(text.begin(), text.end());
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips)
      bytes[random() % bytes.size()] ^= std::uint8_t(1u << random() % 8);
    CAPTURE(round);
    CHECK(loads_or_refuses(folder.write("flipped.glb", bytes)));
  }
}

TEST_CASE("random words in the data of an animated file load or are refused") {
  const Folder folder;
  std::mt19937 random(20240609);
  for (int round = 0; round < 2000; ++round) {
    Builder builder = everything();
    const std::size_t animated = builder.bin.size() - 4 * (3 + 9 + 12 + 9 + 36 + 27 + 9);
    const std::size_t at = animated + 4 * (random() % ((builder.bin.size() - animated) / 4));
    const auto word = std::uint32_t(random());
    std::memcpy(builder.bin.data() + at, &word, 4);
    CAPTURE(round);
    CHECK(loads_or_refuses(folder.write("word.glb", builder.glb())));
  }
}

TEST_CASE("numbers of an animation replaced by absurd ones load or are refused") {
  const Folder folder;
  const std::string text = everything().gltf();
  const std::size_t end = text.find("base64,");
  int round = 0;
  for (std::size_t at = text.find(R"("nodes":[{)"); at < end; ++at) {
    const bool starts = std::isdigit(static_cast<unsigned char>(text[at])) && text[at - 1] != '.' &&
                        !std::isalnum(static_cast<unsigned char>(text[at - 1])) && text[at - 1] != '_';
    if (!starts) continue;
    std::size_t stop = at;
    while (std::isdigit(static_cast<unsigned char>(text[stop])) || text[stop] == '.') ++stop;
    for (const char* number : {"-1", "1", "3", "255", "2147483647", "18446744073709551615", "1e30", "1e308",
                               "0", "null", "[]", "\"a\""}) {
      CAPTURE(number);
      CAPTURE(at);
      ++round;
      CHECK(loads_or_refuses(folder.write("number.gltf", text.substr(0, at) + number + text.substr(stop))));
    }
  }
  CHECK(round > 300);
}
