#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/error.h"
#include "core/base/text.h"
#include "tests/evaluation/evaluate_fixture.h"
#include "tests/evaluation/visibility_fixture.h"

namespace uniquadric {
namespace {

constexpr double kNs = 1e-9;

class Presence : public VisibilityFixture {};

TEST_F(Presence, HiddenFramesAreNoMisses) {
  // Out of view in frames 8 to 11, behind something in 12 to 14; lost from 6 to 17.
  write_visibility([](int frame) -> View {
    return frame >= 8 && frame < 12 ? View{0, 0} : frame >= 12 && frame < 15 ? View{20, 1000} : View{};
  });
  write_changed([](Tracks& tracks) {
    auto& states = tracks.objects[0].states;
    states.erase(states.begin() + 6, states.begin() + 18);
  });
  const json result = run();
  const json& cuboid = result["objects"][0];
  EXPECT_EQ(cuboid["frames"], kFrames);
  EXPECT_EQ(cuboid["visible_frames"], kFrames - 7);
  EXPECT_EQ(cuboid["matched_frames"], kFrames - 12);
  EXPECT_NEAR(cuboid["coverage"], 18.0 / 23, 1e-15);
  EXPECT_NEAR(cuboid["coverage_of_all_frames"], 18.0 / 30, 1e-15);
  EXPECT_NEAR(cuboid["longest_gap_s"], 5 * kPeriodNs * kNs, 1e-12);  // frames 6, 7, 15, 16, 17
  EXPECT_EQ(cuboid["ape"]["translation_m"]["n"], 18);
  // 5 misses among the 83 frames in which some object can be seen
  EXPECT_NEAR(result["tracking"]["mota"], 78.0 / 83, 1e-12);
  EXPECT_NEAR(result["tracking"]["idf1"], 2 * 78.0 / (83 + 78), 1e-12);
}

TEST_F(Presence, AHoleOfTheTruthIsNoGap) {
  write_changed([](Tracks& tracks) {
    auto& states = tracks.objects[0].states;
    states.erase(states.begin() + 15);
    states.erase(states.begin() + 9);
  });
  write_hole_in_truth(10, 15);
  const json cuboid = run()["objects"][0];
  EXPECT_EQ(cuboid["frames"], kFrames - 5);
  EXPECT_NEAR(cuboid["longest_gap_s"], 2 * kPeriodNs * kNs, 1e-12);  // frames 9 and 15
}

TEST_F(Presence, EnoughIsATenthOfTheSilhouetteAndFiftyPixels) {
  const std::vector<View> views = {{99, 1000}, {100, 1000}, {49, 49}, {50, 50}, {0, 0}};
  write_visibility([&](int frame) { return frame < 5 ? views[frame] : View{}; });
  write_changed([](Tracks& tracks) {
    auto& states = tracks.objects[0].states;
    states.erase(states.begin(), states.begin() + 5);
  });
  const json cuboid = run()["objects"][0];
  EXPECT_EQ(cuboid["visible_frames"], kFrames - 3);
  EXPECT_NEAR(cuboid["coverage"], 25.0 / 27, 1e-15);
}

TEST_F(Presence, AStateOfAHiddenObjectIsNeitherHitNorFalseTrack) {
  write_visibility([](int frame) { return frame >= 10 && frame < 15 ? View{0, 1000} : View{}; });
  write_changed([](Tracks& tracks) {
    for (int i = 10; i < 15; ++i)  // predicted, and far off in the end
      tracks.objects[0].states[i].ellipsoid.world_from_object.translation.y() += 0.1 * (i - 9);
  });
  const json result = run();
  EXPECT_EQ(result["objects"][0]["coverage"], 1);
  EXPECT_EQ(result["objects"][0]["ape"]["translation_m"]["n"], kFrames);  // its error counts
  EXPECT_NEAR(result["objects"][0]["ape"]["translation_m"]["max"], 0.5, kRounding);
  for (const char* key : {"hota", "mota", "idf1"}) EXPECT_NEAR(result["tracking"][key], 1, 1e-12) << key;
}

TEST_F(Presence, ATrackThatJumpsToAVisibleObjectMeanwhileIsWrong) {
  write_visibility([](int frame) { return frame >= 10 && frame < 20 ? View{0, 1000} : View{}; });
  write_changed([](Tracks& tracks) {
    for (int i = 10; i < 20; ++i)  // the hidden cuboid's track follows the cube, whose own is lost
      tracks.objects[0].states[i].ellipsoid = tracks.objects[1].states[i].ellipsoid;
    auto& cube = tracks.objects[1].states;
    cube.erase(cube.begin() + 10, cube.begin() + 20);
  });
  const json result = run();
  EXPECT_EQ(result["objects"][1]["id_switches"], 2);  // to the other track and back
  EXPECT_NEAR(result["tracking"]["mota"], 1 - 2.0 / 80, 1e-12);
  EXPECT_LT(result["tracking"]["idf1"], 0.9);
}

TEST_F(Presence, AnObjectThatIsNeverVisibleHasNoCoverage) {
  write_visibility([](int) { return View{0, 1000}; });
  write_changed([](Tracks&) {});
  const json cuboid = run()["objects"][0];
  EXPECT_EQ(cuboid["visible_frames"], 0);
  EXPECT_TRUE(cuboid["coverage"].is_null());
  EXPECT_TRUE(cuboid["longest_gap_s"].is_null());
  EXPECT_EQ(cuboid["coverage_of_all_frames"], 1);
}

TEST_F(Presence, FramesCsvSaysWhatWasVisible) {
  write_visibility([](int frame) { return frame == 3 ? View{40, 1000} : View{}; });
  write_changed([](Tracks&) {});
  run();
  int hidden = 0;
  for_each_line(
      root_ / "out/frames.csv",
      [&](int line, const auto& fields) {
        const std::size_t n = fields.size() - 3;  // sigmas stand last
        if (line == 1) {
          EXPECT_EQ(fields[n - 4], "visible_fraction");
          EXPECT_EQ(fields[n - 3], "visible");
          EXPECT_EQ(fields[n - 2], "occluded");
          EXPECT_EQ(fields[n - 1], "arc_deg");
        } else if (fields[n - 3] == "0") {
          EXPECT_EQ(fields[0], "3");
          EXPECT_EQ(fields[2], "1");
          EXPECT_EQ(fields[n - 4], "0.04");
          EXPECT_EQ(fields[n - 2], "1");
          ++hidden;
        }
      },
      ',');
  EXPECT_EQ(hidden, 1);
}

// Axes by hand: 0.30 before both occlusions; the first makes them 0.27 and 0.312 (10 % and 4 %), the second,
// which only the estimate calls one, 0.36 of a 0.40 that they had become (10 % again, but for y: 0.30 of 0.20
// is 50 %).
TEST_F(Presence, SizesAreHeldAgainstThoseBeforeTheOcclusion) {
  write_visibility([](int frame) { return frame >= 5 && frame < 8 ? View{499, 1000} : View{500, 1000}; });
  const auto change = [&](double y_in_second) {
    write_changed([&](Tracks& tracks) {
      auto& states = tracks.objects[0].states;
      for (auto& state : states) state.ellipsoid.semi_axes_m = {0.3, 0.3, 0.3};
      states[5].ellipsoid.semi_axes_m.x() = 0.27;
      states[6].ellipsoid.semi_axes_m.z() = 0.312;
      for (int i = 12; i < kFrames; ++i) states[i].ellipsoid.semi_axes_m = {0.4, 0.2, 0.3};
      for (int i = 20; i < 24; ++i) {
        states[i].status = ObjectStatus::occluded;
        states[i].ellipsoid.semi_axes_m.y() = y_in_second;
      }
    });
    return run()["objects"][0]["semi_axes_change_occluded_max"].get<double>();
  };
  EXPECT_NEAR(change(0.2), 0.1, 1e-12);
  EXPECT_NEAR(change(0.3), 0.5, 1e-12);
  EXPECT_TRUE(run()["objects"][1]["semi_axes_change_occluded_max"].is_null());
}

TEST_F(Presence, WithoutAStateBeforeAnOcclusionThereIsNoChange) {
  write_visibility([](int frame) { return frame < 8 ? View{100, 1000} : View{}; });
  write_changed([](Tracks& tracks) { tracks.objects[0].states[3].ellipsoid.semi_axes_m *= 2; });
  EXPECT_TRUE(run()["objects"][0]["semi_axes_change_occluded_max"].is_null());
}

TEST_F(Presence, IouAfterTheFirstThreeSeconds) {
  constexpr std::int64_t kSlow_ns = 250'000'000;  // 4 frames a second
  write_truth(kSlow_ns);
  write_changed([](Tracks& tracks) {
    auto& states = tracks.objects[2].states;  // the ball, at first seen in frame 2
    states.erase(states.begin(), states.begin() + 2);
    for (auto& state : states)
      if (state.frame < 14) state.ellipsoid.semi_axes_m /= 2;  // settles at frame 14, 3 s later
  });
  const json result = run();
  const json& ball = result["objects"][2];
  EXPECT_NEAR(ball["iou3d"]["mean"], (12 * 0.125 + 16) / 28, 1e-9);
  EXPECT_EQ(ball["iou3d_after_3s"]["n"], 16);
  EXPECT_NEAR(ball["iou3d_after_3s"]["mean"], 1, 1e-12);
  EXPECT_NEAR(ball["iou2d_after_3s"]["mean"], 1, 1e-12);
  EXPECT_EQ(ball["after_3s"]["frames"], 16);
  EXPECT_EQ(ball["after_3s"]["ape"]["translation_m"]["n"], 16);
  EXPECT_EQ(ball["after_3s"]["rpe"]["translation_m"]["n"], 15);  // none from the last frame before
  EXPECT_NEAR(ball["after_3s"]["iou3d_solid"]["mean"], 1, 1e-12);
  write_truth(kPeriodNs);  // a second is over before
  write_changed([](Tracks&) {});
  EXPECT_TRUE(run()["objects"][0]["iou3d_after_3s"].is_null());
  EXPECT_EQ(run()["objects"][0]["after_3s"]["frames"], 0);
}

TEST_F(Presence, FiguresInViewEqualTheOthersOfWhatIsAlwaysVisible) {
  write_visibility([](int) { return View{}; });
  write_changed([](Tracks& tracks) {
    for (ObjectState& state : tracks.objects[0].states)
      state.ellipsoid.world_from_object.translation.x() += 0.001 * static_cast<double>(state.frame % 7);
  });
  const json cuboid = run()["objects"][0];
  EXPECT_EQ(cuboid["in_view"]["frames"], kFrames);
  EXPECT_EQ(cuboid["in_view"]["matched_frames"], kFrames);
  for (const char* part : {"translation_m", "rotation_rad"}) {
    EXPECT_EQ(cuboid["in_view"]["ape"][part], cuboid["ape"][part]);
    EXPECT_EQ(cuboid["in_view"]["rpe"][part], cuboid["rpe"][part]);
  }
  EXPECT_EQ(cuboid["in_view"]["iou2d"], cuboid["iou2d"]);
  EXPECT_EQ(cuboid["in_view"]["iou3d_solid"]["n"], kFrames);
  EXPECT_NEAR(cuboid["in_view"]["iou3d_solid"]["mean"], cuboid["iou3d_solid"]["mean"], 1e-9);
  EXPECT_GT(cuboid["in_view"]["ape"]["translation_m"]["rmse"], 0.001);
}

// Off by 0.4 m while hidden in frames 10 to 14, by 0.1 m else. The steps into and out of them are not in
// view.
TEST_F(Presence, FiguresInViewLeaveOutHiddenFrames) {
  write_visibility([](int frame) { return frame >= 10 && frame < 15 ? View{0, 1000} : View{}; });
  write_changed([](Tracks& tracks) {
    for (ObjectState& state : tracks.objects[0].states)
      state.ellipsoid.world_from_object.translation.x() += state.frame >= 10 && state.frame < 15 ? 0.4 : 0.1;
  });
  const json result = run();
  const json& cuboid = result["objects"][0];
  const json& in_view = cuboid["in_view"];
  EXPECT_EQ(in_view["frames"], kFrames - 5);
  EXPECT_EQ(in_view["ape"]["translation_m"]["n"], kFrames - 5);
  EXPECT_NEAR(in_view["ape"]["translation_m"]["rmse"], 0.1, kRounding);
  EXPECT_NEAR(cuboid["ape"]["translation_m"]["rmse"], std::sqrt((25 * 0.01 + 5 * 0.16) / 30), kRounding);
  EXPECT_EQ(in_view["rpe"]["translation_m"]["n"], 9 + 14);
  EXPECT_GT(cuboid["rpe"]["translation_m"]["max"], 0.2);
  EXPECT_LT(in_view["rpe"]["translation_m"]["max"], 0.01);
  EXPECT_EQ(in_view["iou2d"]["n"], kFrames - 5);
  EXPECT_GT(in_view["iou2d"]["mean"], cuboid["iou2d"]["mean"]);
  EXPECT_EQ(in_view["iou3d_solid"]["n"], kFrames - 5);
  EXPECT_GT(in_view["iou3d_solid"]["mean"], cuboid["iou3d_solid"]["mean"]);
}

TEST_F(Presence, WithoutVisibilityNothingIsInView) {
  write_changed([](Tracks&) {});
  EXPECT_TRUE(run()["objects"][0]["in_view"].is_null());
  write_visibility([](int) { return View{0, 1000}; });
  const json hidden = run()["objects"][0]["in_view"];
  EXPECT_EQ(hidden["frames"], 0);
  EXPECT_TRUE(hidden["ape"]["translation_m"].is_null());
}

// The truth turned so that the cuboid is seen from a direction that goes round it by 4.1 degrees a frame.
class Arc : public Presence {
 protected:
  static constexpr double kStep_deg = 4.1;
  void write_orbit() {
    Trajectory camera, cuboid;
    for (int i = 0; i < kFrames; ++i) {
      const double angle = i * kStep_deg * std::numbers::pi / 180;
      camera.push_back({i * kPeriodNs, camera_pose(i)});
      // Half of the way by the body's own turn, half by its path around the camera.
      const Eigen::Vector3d from_camera(std::sin(angle / 2), 0, std::cos(angle / 2));
      cuboid.push_back(
          {i * kPeriodNs,
           {exp_so3({0, -angle / 2, 0}), camera_pose(i).translation + (2 + 0.1 * i) * from_camera}});
    }
    write_tum(truth() / "camera.tum", camera);
    write_tum(truth() / "objects/1.tum", cuboid);
  }
  // The column of the cuboid, a frame an entry; empty fields as nothing.
  std::vector<std::optional<double>> arcs() const {
    std::vector<std::optional<double>> values;
    for_each_line(
        root_ / "out/frames.csv",
        [&](int line, const auto& fields) {
          if (line > 1 && fields[2] == "1") values.push_back(parse_double(fields[fields.size() - 4]));
        },
        ',');
    return values;
  }
};

TEST_F(Arc, IsTheLargestAngleBetweenTwoViewsSoFar) {
  write_orbit();
  write_visibility([](int frame) { return frame < 2 || frame == 20 ? View{0, 1000} : View{}; });
  write_changed([](Tracks&) {});
  run();
  const auto values = arcs();
  ASSERT_EQ(values.size(), std::size_t{kFrames});
  constexpr double kTolerance_deg = 1e-5;  // acos near 0, at the digits of a cosine
  for (int i = 0; i < kFrames; ++i) {
    const int last = i == 20 ? 19 : i;  // what is hidden adds nothing
    if (i < 2)
      EXPECT_FALSE(values[i]) << i;
    else
      EXPECT_NEAR(values[i].value(), (last - 2) * kStep_deg, kTolerance_deg) << i;
  }
}

TEST_F(Arc, IouFromFortyDegreesOnIsThatOfTheFramesWithIt) {
  write_orbit();
  write_visibility([](int) { return View{}; });
  write_changed([](Tracks& tracks) {
    for (auto& state : tracks.objects[0].states)
      if (state.frame < 12) state.ellipsoid.semi_axes_m /= 2;  // 41 degrees in frame 10
  });
  const json result = run();
  EXPECT_EQ(result["objects"][0]["iou3d_from_40deg"]["n"], kFrames - 10);
  EXPECT_NEAR(result["objects"][0]["iou3d_from_40deg"]["mean"], (2 * 0.125 + 18) / 20, 1e-9);
  write_truth();
  EXPECT_TRUE(run()["objects"][0]["iou3d_from_40deg"].is_null());  // never seen so widely
}

TEST_F(Presence, WarnsOfFramesThatTheVisibilityTableLacks) {
  write_visibility([](int) { return View{}; });
  write_changed([](Tracks&) {});
  const auto said = [&] {
    testing::internal::CaptureStderr();
    run();
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(said(), "");
  const fs::path file = truth() / "instances/visibility.csv";
  std::string text = read_text(file);
  for (int rows = 0; rows < 2; ++rows) text.erase(text.rfind('\n', text.size() - 2) + 1);
  write_text(file, text);
  EXPECT_NE(said().find("visibility.csv: has no row of 2 of 90 true states, which count as visible"),
            std::string::npos);
}

TEST_F(Presence, RefusesABrokenVisibilityTable) {
  write_changed([](Tracks&) {});
  const std::string header =
      "frame,timestamp_ns,id,visible_px,silhouette_px,visible_fraction,touches_border\n";
  fs::create_directories(truth() / "instances");
  for (const char* rows : {"0,0,1,5,5,1\n", "0,0,1,5,5,nan,0\n", "0,0,1,-5,5,1,0\n", "0,0,1,5,5,1.5,0\n",
                           "0,0,1,5,5,1,2\n", "x,0,1,5,5,1,0\n", "0,0,1,5,5,1,0\n0,0,1,5,5,1,0\n"}) {
    write_text(truth() / "instances/visibility.csv", header + rows);
    EXPECT_THROW(run(), InputError) << rows;
  }
  for (const char* text : {"", "frame,id\n"}) {
    write_text(truth() / "instances/visibility.csv", text);
    EXPECT_THROW(run(), InputError) << text;
  }
}

}  // namespace
}  // namespace uniquadric
