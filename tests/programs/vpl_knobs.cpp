// The knobs of glossy_vpls: what they do to the light, down to scenes without any.
#include "programs/vpl_studio.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

TEST_CASE("gathering tends to the sum over all VPLs as the threshold falls, and is that at 0") {
  const Studio place;
  double last_error = 1, last_nodes = 0;
  for (const std::string threshold : {"0.1", "0.01", "0.001", "0"}) {
    CAPTURE(threshold);
    const json frame = place.measured("--threshold " + threshold);
    CHECK(error_of(frame) < last_error);
    CHECK(frame["nodes"]["mean"] > last_nodes);
    last_error = error_of(frame), last_nodes = frame["nodes"]["mean"];
    if (threshold == "0.01") CHECK(last_error < 0.02);
    if (threshold == "0.001") CHECK(last_error < 0.002);
  }
  CHECK(last_error < 1e-5);
}

TEST_CASE("any number of VPLs will do, none among them; direct light needs none") {
  const Studio place;
  place.shone("");
  const Image direct = place.part("direct");
  for (const std::string count : {"0", "1", "2", "17"}) {
    CAPTURE(count);
    const json frame = place.measured("--threshold 0 --vpls " + count);
    CHECK(frame["vpls"]["placed"] == std::stoi(count));
    CHECK(error_of(frame) < 1e-5);
    CHECK(place.part("direct").pixels == direct.pixels);
    for (const vec3& p : place.part("indirect").pixels) CHECK(is_finite(p));
    if (count == "0") CHECK(is_black(place.part("indirect")));
  }
  CHECK_FALSE(is_black(place.part("indirect")));
}

TEST_CASE("no VPLs are no trouble to any way of gathering") {
  const Studio place;
  for (const std::string way : {"--criterion angle", "--visibility traced", "--adaptive relative",
                                "--filter uniform", "--bounces 3", "--frames 2 --animate"}) {
    CAPTURE(way);
    REQUIRE(place.shine("--vpls 0 --reference --out image.exr " + way).code == 0);
    const bool is_one = place.made().contains("image.exr");
    CHECK(is_black(layer(place / (is_one ? "image.exr" : "image.0001.exr"), "indirect")));
    std::filesystem::remove(place / "image.exr");
  }
}

TEST_CASE("a room in the dark is black, with a warning") {
  const Studio place({.is_shining = false});
  for (const std::string way :
       {"", "--criterion angle", "--visibility traced", "--adaptive relative", "--bounces 2"}) {
    CAPTURE(way);
    const Outcome o = place.shine("--reference --out image.exr --report report.json " + way);
    REQUIRE(o.code == 0);
    CHECK(o.err.find("warning: nothing shines") != std::string::npos);
    CHECK(is_black(read_image(place / "image.exr")));
    CHECK(place.report()["warnings"].back().get<std::string>().find("nothing shines") != std::string::npos);
    CHECK(place.report()["frames"][0]["vpls"]["shining"] == 0);
    CHECK(place.report()["frames"][0]["errors"]["rel_rmse"] == 0);
  }
}

TEST_CASE("a scene without triangles gives a black image without VPLs") {
  const Studio place;
  files::put(place / "none.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[]}]})");
  for (const std::string way : {"", "--criterion angle", "--visibility traced", "--adaptive relative",
                                "--env sky.hdr --bounces 2", "--spread repulsion"}) {
    CAPTURE(way);
    const Image indirect = place.shone("--scene none.gltf --reference " + way);
    CHECK(is_black(indirect));
    CHECK(is_black(read_image(place / "image.exr")));
    CHECK(place.report()["preparation"]["vpls"] == 0);
  }
}

TEST_CASE("clusters by solid angle near the sum too, and min-max cuts cost accuracy") {
  const Studio place;
  const json coarse = place.measured("--criterion angle --threshold 0.5"),
             fine = place.measured("--criterion angle --threshold 0.002"),
             flat = place.measured("--criterion angle --threshold 0.002 --min-max 1000000:9");
  CHECK(error_of(fine) < 0.01);
  CHECK(error_of(coarse) > error_of(fine));
  CHECK(coarse["nodes"]["mean"] < fine["nodes"]["mean"]);
  CHECK(flat["nodes"]["mean"] < fine["nodes"]["mean"]);
  CHECK(error_of(flat) > error_of(fine));
}

TEST_CASE("every tree sums all VPLs at threshold 0, and errs a little above") {
  const Studio place;
  const Image usual = place.shone("");
  for (const std::string tree :
       {"--clustering kd", "--clustering lengths", "--filter uniform", "--clustering kd --filter uniform"}) {
    CAPTURE(tree);
    CHECK(error_of(place.measured("--threshold 0 " + tree)) < 1e-5);
    CHECK(error_of(place.measured(tree)) < 0.05);
    const double difference = rel_rmse(place.part("indirect"), usual);
    CHECK(difference > 1e-6);
    CHECK(difference < 0.05);
  }
}

TEST_CASE("wherever VPLs are put, they bring about the same light") {
  const Studio place;
  const Image usual = place.shone("--vpls 1024");
  for (const std::string where :
       {"--density area", "--density irradiance", "--spread repulsion", "--seed 9"}) {
    CAPTURE(where);
    const Image image = place.shone("--vpls 1024 " + where);
    const double difference = rel_rmse(image, usual);
    CHECK(difference > 0.001);
    CHECK(difference < 0.3);
    CHECK(std::abs(mean(image) / mean(usual) - 1) < 0.05);
  }
}

TEST_CASE("a seed tells where VPLs lie, and the same seed gives the same file") {
  const Studio place({.is_shining = false});
  const Image usual = place.shone("--env sky.hdr");  // whose lights no seed turns
  const std::string bytes = files::get(place / "image.exr");
  CHECK(place.shone("--env sky.hdr --seed 0").pixels == usual.pixels);
  CHECK(files::get(place / "image.exr") == bytes);
  const Image other = place.shone("--env sky.hdr --seed 7");
  CHECK(rel_rmse(other, usual) > 0.001);
  CHECK(std::abs(mean(other) / mean(usual) - 1) < 0.1);
}

TEST_CASE("each bounce adds light, and less than the one before") {
  const Studio place;
  const double one = mean(place.shone("--bounces 1")), two = mean(place.shone("--bounces 2")),
               three = mean(place.shone("--bounces 3"));
  CHECK(two > 1.1 * one);
  CHECK(three > two);
  CHECK(three - two < two - one);
}

TEST_CASE("exponents make every material glossy, the sharper the higher they are") {
  const Studio place;
  const Image usual = place.shone(""), blunt = place.shone("--exponents 5:60"),
              sharp = place.shone("--exponents 100:500");
  CHECK(rel_rmse(blunt, usual) > 0.01);
  CHECK(rel_rmse(sharp, blunt) > 0.01);
  CHECK(mean(blunt) > 0.5 * mean(usual));
  CHECK(mean(blunt) < 2 * mean(usual));
  CHECK(error_of(place.measured("--exponents 100:500 --threshold 0.001")) < 0.01);
}

TEST_CASE("an environment shines into the room as distant lights, and turns") {
  const Studio place({.is_shining = false});
  const Image indirect = place.shone("--env sky.hdr");
  CHECK(place.report()["warnings"].empty());
  CHECK(mean(indirect) > 0);
  CHECK(mean(place.part("direct")) > 0);
  const Image turned = place.shone("--env sky.hdr --rotate-env 120");
  CHECK(rel_rmse(turned, indirect) > 0.02);
  REQUIRE(place.shine("--env sky.hdr --rotate-env 60 --frames 3 --out turn.exr").code == 0);
  CHECK(rel_rmse(layer(place / "turn.0000.exr", "indirect"), indirect) < 0.02);
  const Image last = layer(place / "turn.0002.exr", "indirect");
  CHECK(rel_rmse(last, turned) < rel_rmse(last, indirect));
}

TEST_CASE("traced visibility at threshold 0 is a ray to every VPL") {
  const Studio place;
  for (const std::string choice : {"energy", "contribution"}) {
    CAPTURE(choice);
    const json frame = place.measured("--visibility traced --threshold 0 --ray-choice " + choice);
    CHECK(error_of(frame) < 1e-5);
    CHECK(frame["shadow_rays"]["mean"] > 10);
    CHECK(frame["shadow_rays"]["max"] <= frame["vpls"]["shining"]);
    CHECK_FALSE(frame.contains("nodes"));
  }
  const Image seen = place.part("indirect");
  const double all = mean(place.shone(""));  // the box hides VPLs
  CHECK(mean(seen) < 0.99 * all);
  CHECK(mean(seen) > 0.3 * all);
}

TEST_CASE("a ray a cluster is right in the mean over seeds") {
  const Studio place;
  for (const std::string choice : {"energy", "contribution"}) {
    CAPTURE(choice);
    const int seeds = 12;
    Image traced(32, 24), reference(32, 24);
    double squares = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
      const json frame = place.measured("--size 32x24 --visibility traced --threshold 0.05 --ray-choice " +
                                        choice + " --seed " + std::to_string(seed));
      CHECK(frame["shadow_rays"]["mean"] < 150);
      squares += error_of(frame) * error_of(frame);
      const Image one = place.part("indirect"), all = place.part("reference");
      for (std::size_t i = 0; i < one.pixels.size(); ++i)
        traced.pixels[i] += one.pixels[i], reference.pixels[i] += all.pixels[i];
    }
    const double noise = std::sqrt(squares / seeds);
    CHECK(noise > 0.005);
    CHECK(rel_rmse(traced, reference) < 0.5 * noise);  // 0.29 of it where there is no bias
    CHECK(std::abs(mean(traced) / mean(reference) - 1) < 0.1 * noise);
  }
}

TEST_CASE("some pixels are gathered, the others interpolated, and all of them with epsilon 0") {
  const Studio place;
  const Image all = place.shone("");
  const Channel alpha = read_channel(place / "image.exr", "A");
  const auto covered = std::ranges::count(alpha.values, 1.0f);
  for (const std::string way : {"relative", "paper", "uniform2", "uniform4"}) {
    CAPTURE(way);
    const Image image = place.shone("--adaptive " + way);
    const Channel steps = read_channel(place / "image.exr", "sampled.R"),
                  sizes = read_channel(place / "image.exr", "cut_size.Y");
    const json frame = place.report()["frames"][0];
    std::ptrdiff_t gathered = 0;
    for (std::size_t i = 0; i < steps.values.size(); ++i) {
      CHECK(std::set<float>{0, 1, 2, 4, 8, 16}.contains(steps.values[i]));
      CHECK((steps.values[i] > 0) == (sizes.values[i] > 0));
      if (alpha.values[i] == 0) CHECK(steps.values[i] == 0);
      gathered += steps.values[i] > 0;
    }
    CHECK(frame["gathered_pixels"] == gathered);
    CHECK(gathered < covered);
    CHECK(gathered > covered / 20);
    CHECK(rel_rmse(image, all) < 0.2);
  }
  const Image each = place.shone("--adaptive relative --epsilon 0");
  CHECK(place.report()["frames"][0]["gathered_pixels"] == covered);
  CHECK(rel_rmse(each, all) < 0.02);
}
