#include "simulator/families/family.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "core/base/config.h"
#include "core/base/files.h"
#include "core/sequence/calibration.h"
#include "simulator/scene/body_reader.h"
#include "simulator/scene/scene.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

constexpr int kScenes = 6;  // of each family

Scene scene_of(const std::string& family, std::uint64_t seed, const std::vector<ConfigOverride>& set = {}) {
  return parse_scene(generate_scene({family, seed, set}), family + ".yaml");
}

double seconds_of(const Scene& scene, std::int64_t frame) {
  return static_cast<double>(scene.stamp_ns(frame)) * 1e-9;
}

bool is_in_view(const Scene& scene, const Body& body, double time_s) {
  const Pose camera_from_world = scene.camera_motion.at(time_s).inverse();
  const auto pixel = scene.camera.project(camera_from_world * body.motion.at(time_s).translation);
  return pixel && scene.camera.contains(*pixel);
}

// Whether places in the box of `a`, a tenth of it apart, lie in that of `b`.
bool reaches_into(const Body& a, const Body& b, double time_s) {
  const Pose b_from_a = b.motion.at(time_s).inverse() * a.motion.at(time_s);
  for (int i = 0; i < 11 * 11 * 11; ++i) {
    const Eigen::Array3d share(i % 11 / 5.0 - 1, i / 11 % 11 / 5.0 - 1, i / 121 / 5.0 - 1);
    const Eigen::Vector3d place = b_from_a * (share * a.semi_axes_m.array()).matrix();
    if ((place.cwiseAbs().array() < b.semi_axes_m.array()).all()) return true;
  }
  return false;
}

class Family : public testing::TestWithParam<std::string> {};

TEST_P(Family, IsTheSameForTheSameSeed) {
  EXPECT_EQ(generate_scene({GetParam(), 7, {}}), generate_scene({GetParam(), 7, {}}));
  EXPECT_NE(generate_scene({GetParam(), 7, {}}), generate_scene({GetParam(), 8, {}}));
}

TEST_P(Family, NothingIsInsideAnythingElse) {
  for (int seed = 0; seed < kScenes; ++seed) {
    const Scene scene = scene_of(GetParam(), static_cast<std::uint64_t>(seed));
    for (std::int64_t frame = 0; frame < scene.frames; frame += 5)
      for (const Body& a : scene.objects)
        for (const Body& b : scene.objects) {
          if (a.id >= b.id || !a.is_scored || !b.is_scored) continue;  // a hand holds on
          const double time_s = seconds_of(scene, frame);
          EXPECT_FALSE(reaches_into(a, b, time_s) || reaches_into(b, a, time_s))
              << fmt::format("seed {}, frame {}: {} and {}", seed, frame, a.name, b.name);
        }
  }
}

TEST_P(Family, EveryObjectIsInViewAtSomeTime) {
  for (int seed = 0; seed < kScenes; ++seed) {
    const Scene scene = scene_of(GetParam(), static_cast<std::uint64_t>(seed));
    for (const Body& body : scene.objects) {
      bool is_seen = false;
      for (std::int64_t frame = 0; frame < scene.frames; ++frame)
        is_seen = is_seen || is_in_view(scene, body, seconds_of(scene, frame));
      EXPECT_TRUE(is_seen) << seed << ": " << body.name;
    }
  }
}

TEST_P(Family, HasScenesOfAsFewFramesAsOne) {
  for (const int frames : {1, 2})
    for (std::uint64_t seed = 0; seed < 2; ++seed)
      EXPECT_EQ(scene_of(GetParam(), seed, {{"frames", fmt::format("{}", frames)}}).frames, frames);
}

INSTANTIATE_TEST_SUITE_P(All, Family, testing::ValuesIn(family_names()),
                         [](const auto& family) { return family.param; });

TEST(Lens, EveryDrawnOneHasARayForEachPixel) {
  int bent = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const ConfigNode node = ConfigNode::parse(generate_scene({"room", seed, {{"frames", "1"}}}), "room");
    const auto calibration = node.at("camera").find("calibration");
    if (!calibration) continue;
    ++bent;
    const Camera camera = read_camera(*calibration);
    for (const double u : {0, camera.width - 1})
      for (const double v : {0, camera.height - 1}) EXPECT_TRUE(camera.unproject({u, v})) << seed;
  }
  EXPECT_GT(bent, 400);
  EXPECT_LT(bent, 600);
}

// What lies on a table touches it, and nothing sinks in.
TEST(Tabletop, ThingsStandOnTheTableOrAreInTheAir) {
  for (std::uint64_t seed = 0; seed < kScenes; ++seed) {
    const Scene scene = scene_of("tabletop", seed);
    bool something_moves = false;
    for (const Body& body : scene.objects) {
      double least_m = 1e9, path_m = 0;
      for (std::int64_t frame = 0; frame < scene.frames; ++frame) {
        const Pose pose = body.motion.at(seconds_of(scene, frame));
        const Eigen::Vector3d down = pose.rotation.conjugate() * Eigen::Vector3d::UnitZ();
        least_m = std::min(least_m, pose.translation.z() - down.cwiseAbs().dot(body.semi_axes_m));
        if (frame > 0)
          path_m += (pose.translation - body.motion.at(seconds_of(scene, frame - 1)).translation).norm();
      }
      EXPECT_NEAR(least_m, 0.72, 2e-3) << seed << ": " << body.name;
      something_moves = something_moves || path_m > 0.05;
    }
    EXPECT_TRUE(something_moves) << seed;
  }
}

// The kerbs of the street that is drawn: 7 m from the backs of its houses.
TEST(Tossed, NothingFliesThroughTheWalls) {
  constexpr double kWall_m = 3;
  for (const int seed : {303, 308, 334}) {  // fast ones, of which one came through a wall each
    const Scene scene = scene_of("tossed", seed, {{"difficulty", "1"}});
    for (const Body& body : scene.objects)
      EXPECT_LT(body.motion.at(seconds_of(scene, scene.frames)).translation.head<2>().cwiseAbs().maxCoeff() +
                    body.semi_axes_m.maxCoeff(),
                kWall_m)
          << seed << " " << body.name;
  }
}

// Hundreds of way-points were one spline, whose error named a file that there is not.
TEST(Handled, SaysWhereAScenesFramesAreTooMany) {
  const std::string said = input_error([] {
    generate_scene({"handled", 1, {{"frames", "20000"}, {"count", "1"}}});
  });
  EXPECT_EQ(said, "handled: frames: no object finds a way clear of the rest for 20000 frames; set fewer");
}

TEST(Handled, TwinsLookAlikeAndOthersDoNot) {
  int twins = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Scene scene = scene_of("handled", seed, {{"count", "3"}, {"frames", "1"}});
    const Body* before = nullptr;
    for (const Body& body : scene.objects) {
      if (!body.is_scored) continue;
      if (before && !body.meshes.empty()) {
        const bool is_twin = body.semi_axes_m == before->semi_axes_m;
        const cv::Mat &a = before->meshes[0].texture, &b = body.meshes[0].texture;
        const bool looks_alike = a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
        EXPECT_EQ(looks_alike, is_twin) << seed << " " << body.name;
        twins += is_twin;
      }
      before = &body;
    }
  }
  EXPECT_GT(twins, 3);
}

// Along the hand's longest axis, from its tip on.
TEST(Handled, AHandReachesNoFurtherInThanItsGrip) {
  int hands = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Scene scene = scene_of("handled", seed, {{"frames", "1"}});
    for (std::size_t i = 1; i < scene.objects.size(); ++i) {
      const Body &hand = scene.objects[i], &held = scene.objects[i - 1];
      if (!hand.name.starts_with("hand")) continue;
      const Pose held_from_hand = held.motion.at(0).inverse() * hand.motion.at(0);
      const Eigen::Vector3d along = held_from_hand.rotation * Eigen::Vector3d(0, hand.semi_axes_m.y(), 0);
      const double side_m = std::abs(held_from_hand.translation.y());
      EXPECT_LT(held.semi_axes_m.y() - (side_m - std::abs(along.y())), 0.0201) << seed;
      ++hands;
    }
  }
  EXPECT_GT(hands, 5);
}

// A rest would change the scenes of results.
TEST(Handled, RestsInNoSceneOfUsualLength) {
  EXPECT_EQ(generate_scene({"handled", 1, {{"difficulty", "1"}}}).find("hold_s"), std::string::npos);
}

TEST(Handled, TheScreenStandsOnTheTable) {
  const Scene scene = scene_of("handled", 1, {{"count", "5"}, {"frames", "90"}});
  const auto find = [&](const char* name) {
    return *std::find_if(scene.world.begin(), scene.world.end(),
                         [&](const auto& b) { return b.name == name; });
  };
  EXPECT_LE(find("screen").semi_axes_m.x(), find("table").semi_axes_m.x());
}

TEST(Street, WhoCrossesComesFromBeyondTheKerbAndTheParkedStandAtIt) {
  int crossing = 0, parked = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Scene scene = scene_of("street", seed, {{"difficulty", "1"}});
    ASSERT_EQ(scene.world.front().shape, "street");
    const double kerb_m = scene.world.front().semi_axes_m.y() - 7;
    for (const Body& body : scene.objects) {
      const Pose begin = body.motion.at(-1000), end = body.motion.at(1000);
      const bool crosses = body.motion.at(1000).translation == body.motion.at(2000).translation &&
                           std::abs(end.translation.y() - begin.translation.y()) > 1;  // from rest to rest
      if (crosses) {
        EXPECT_GT(std::min(std::abs(begin.translation.y()), std::abs(end.translation.y())), kerb_m)
            << body.name;
        EXPECT_NEAR(begin.translation.z() - body.semi_axes_m.z(), 0.15, 5e-3);  // sizes are round
        ++crossing;
      } else {
        EXPECT_LT(std::abs(body.motion.at(0).translation.y()) + body.semi_axes_m.y(), kerb_m) << body.name;
      }
      if ((end.translation - begin.translation).norm() == 0) {
        EXPECT_NEAR(std::abs(begin.translation.y()) + body.semi_axes_m.y(), kerb_m - 0.3, 0.02) << body.name;
        ++parked;
      }
    }
  }
  EXPECT_GT(crossing, 3);
  EXPECT_GT(parked, 3);
}

std::string actor_of(const Body& body) {
  for (const char* name : {"cyclist", "pedestrian"})
    if (body.name.starts_with(name)) return name;
  const Pose first = body.motion.at(0);
  const double y_m = first.translation.y();
  if (std::abs((first.rotation * Eigen::Vector3d::UnitX()).x()) < 0.5) return "crossing";
  if (std::abs(y_m) > 8) return "parked";
  return y_m > 3.3 ? "oncoming" : y_m > 0 ? "overtaking" : "leading";
}

void expect_shares(const std::map<std::string, int>& counts, const std::map<std::string, double>& shares) {
  constexpr double kSigmas = 3;
  double all = 0;
  for (const auto& [kind, count] : counts) all += count;
  EXPECT_GT(all, 180) << "too few to tell";
  for (const auto& [kind, share] : shares)
    EXPECT_NEAR(counts.at(kind) / all, share, kSigmas * std::sqrt(share * (1 - share) / all))
        << kind << " of " << all;
}

// The shares that scenes/families.md says, in scenes so short that some kinds seldom come into view.
TEST(Street, ActorsHaveTheirShares) {
  std::map<std::string, int> actors, vehicles;
  for (std::uint64_t seed = 0; seed < 70; ++seed) {
    const std::string text = generate_scene({"street", seed, {{"frames", "30"}, {"difficulty", "0.5"}}});
    std::vector<std::filesystem::path> files;
    for (const ConfigNode& object : ConfigNode::parse(text, "street").at("objects").items()) {
      const Body body = read_object(object, {.is_painted = false}, files);
      const std::string actor = actor_of(body);
      ++actors[actor];
      if (actor != "cyclist" && actor != "pedestrian" && actor != "crossing")
        ++vehicles[body.name.substr(0, body.name.find('_'))];
    }
  }
  expect_shares(actors, {{"leading", 0.22},
                         {"overtaking", 0.2},
                         {"oncoming", 0.18},
                         {"parked", 0.12},
                         {"crossing", 0.08},
                         {"cyclist", 0.1},
                         {"pedestrian", 0.1}});
  expect_shares(vehicles, {{"car", 0.65}, {"van", 0.23}, {"truck", 0.12}});
}

TEST(Street, NobodyDrivesIntoTheHousesAtItsEnds) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Scene scene = scene_of("street", seed, {{"difficulty", "1"}, {"frames", "600"}});
    const double end_m = scene.world.front().semi_axes_m.x(), last_s = seconds_of(scene, 599);
    for (const Body& body : scene.objects)
      EXPECT_LT(std::abs(body.motion.at(last_s).translation.x()) + body.semi_axes_m.x(), end_m)
          << seed << " " << body.name;
  }
}

TEST(Families, AFlatMeshIsNamed) {
  const TempFolder temp;
  write_text(temp.path() / "sheet.obj", "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nf 1 2 3\n");
  EXPECT_EQ(input_error([&] {
              generate_scene({"tossed", 1, {{"meshes", temp.path().string()}}});
            }),
            (temp.path() / "sheet.obj").string() + ": is flat: an object needs an extent along every axis");
}

// Of those that drive about a third does one or the other in ten seconds; none turns as much as 20 degrees.
TEST(Families, StreetsHaveStopAndGoAndTurns) {
  int drives = 0, stops = 0, turns = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Scene scene = scene_of("street", seed);
    for (const Body& body : scene.objects) {
      double stood_s = 0, fastest_m = 0, turned_rad = 0;
      bool goes_again = false;
      const Pose first = body.motion.at(0);
      for (std::int64_t frame = 1; frame < scene.frames; ++frame) {
        const Pose now = body.motion.at(seconds_of(scene, frame)),
                   before = body.motion.at(seconds_of(scene, frame - 1));
        const double step_m = (now.translation - before.translation).norm();
        if (step_m < 1e-6) stood_s += seconds_of(scene, 1);
        goes_again = goes_again || (stood_s > 0.4 && step_m > 0.01);
        fastest_m = std::max(fastest_m, step_m);
        turned_rad = std::max(turned_rad, now.rotation.angularDistance(first.rotation));
      }
      const bool drives_along = std::abs(first.translation.y()) < 8 && fastest_m > 0.01;
      if (!drives_along) continue;
      ++drives;
      stops += goes_again;
      turns += turned_rad > 0.05;
      EXPECT_LT(turned_rad, 0.35) << seed;
    }
  }
  EXPECT_GT(drives, 20);
  EXPECT_GT(stops, drives / 10);
  EXPECT_GT(turns, drives / 10);
}

// Else all scenes of a bench had the same noise, and missed their masks in the same frames.
TEST(Families, EachSceneHasNoiseOfItsOwn) {
  std::set<std::uint64_t> noises;
  for (const std::string& family : family_names())
    for (const std::uint64_t seed : {1, 2, 3})
      noises.insert(
          parse_scene(generate_scene({family, seed, {{"frames", "1"}}}), "s.yaml", {}, Textures::plain)
              .stream_seed(1));
  EXPECT_EQ(noises.size(), 3 * family_names().size());
}

TEST(Families, TheHarderTheFaster) {
  const auto largest_step_m = [](double difficulty) {
    double step_m = 0;
    for (std::uint64_t seed = 0; seed < kScenes; ++seed) {
      const Scene scene = scene_of("tabletop", seed, {{"difficulty", fmt::format("{}", difficulty)}});
      for (const Body& body : scene.objects)
        for (std::int64_t frame = 1; frame < scene.frames; ++frame)
          step_m = std::max(step_m, (body.motion.at(seconds_of(scene, frame)).translation -
                                     body.motion.at(seconds_of(scene, frame - 1)).translation)
                                        .norm());
    }
    return step_m;
  };
  EXPECT_GT(largest_step_m(1), 2 * largest_step_m(0));
}

TEST(Families, TheHarderTheLessTextureAndTheLargerARoomIs) {
  double before_marks = 100, before_contrast = 1;
  for (const char* difficulty : {"0", "0.5", "1"}) {
    double marks = 0, contrast = 0, largest_m = 0;
    constexpr int kRooms = 40;
    for (std::uint64_t seed = 0; seed < kRooms; ++seed) {
      const std::string text = generate_scene({"room", seed, {{"difficulty", difficulty}, {"frames", "30"}}});
      const ConfigNode room = ConfigNode::parse(text, "room").at("world").items().front();
      marks += room.at("material").get<double>("marks", 0) / kRooms;
      contrast += room.at("material").get<double>("contrast", 0) / kRooms;
      largest_m = std::max(largest_m, room.at("size_m").items().front().as<double>());
    }
    EXPECT_LT(marks, before_marks - 5);
    EXPECT_LT(contrast, before_contrast - 0.15);
    EXPECT_NEAR(largest_m, 5.5 + 1.5 * std::stod(difficulty), 0.3);
    before_marks = marks;
    before_contrast = contrast;
  }
}

TEST(Families, RefuseWhatTheyDoNotHave) {
  const auto refusal = [](const FamilyRequest& request) {
    return input_error([&] { generate_scene(request); });
  };
  EXPECT_EQ(refusal({"tabel", 1, {}}).find("there is no family 'tabel' (known: tabletop, "), 0u);
  EXPECT_EQ(refusal({"room", 1, {{"difficulty", "2"}}}),
            "room: difficulty: expected 0 to 1 (set, not the file's)");
  EXPECT_EQ(refusal({"room", 1, {{"speed", "2"}}}).find("room: unknown key 'speed' (known: "), 0u);
  EXPECT_EQ(refusal({"room", 1, {{"frames", "0"}}}).find("room: frames: expected 1 to "), 0u);
  EXPECT_EQ(refusal({"street", 1, {{"count", "0"}}}),
            "street: count: expected 1 to 100, found 0 (set, not the file's)");
  EXPECT_EQ(refusal({"room", 1, {{"count", "3"}}}).find("room: unknown key 'count' (known: "), 0u);
}

}  // namespace
}  // namespace uniquadric
