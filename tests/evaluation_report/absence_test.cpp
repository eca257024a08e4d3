#include "evaluation/report/absence.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace uniquadric {
namespace {

// Why an object has no outline: each kind of reason once.
TEST(Absence, EveryReasonHasItsLine) {
  Tracks estimate, truth;
  estimate.camera = {{0, {}}, {100'000'000, {}}};
  const auto track = [](int id, std::initializer_list<std::pair<std::int64_t, ObjectStatus>> states) {
    ObjectTrack made{id, "", {}};
    for (const auto& [stamp_ns, status] : states) {
      ObjectState state;
      state.stamp_ns = stamp_ns;
      state.status = status;
      made.states.push_back(state);
    }
    return made;
  };
  constexpr auto kActive = ObjectStatus::active;
  constexpr std::int64_t kLate_ns = 200'000'000;
  estimate.objects = {track(1, {{0, kActive}, {100'000'000, kActive}, {kLate_ns, kActive}}),
                      track(2, {{0, kActive}, {100'000'000, ObjectStatus::lost}, {kLate_ns, kActive}}),
                      track(3, {{0, kActive}, {kLate_ns, kActive}}),
                      track(4, {{0, kActive}, {kLate_ns, kActive}}),
                      track(5, {{kLate_ns, kActive}}),
                      track(6, {{0, kActive}}),
                      track(7, {{0, kActive}, {50'000'000, ObjectStatus::lost}, {kLate_ns, kActive}}),
                      track(8, {{0, kActive}, {50'000'000, ObjectStatus::lost}})};
  truth.objects = {{1, "ball", {}}, {2, "cube", {}}, {3, "car", {}}};
  const VisibilityTable visibility = {
      {{1, 1}, {0, 0, 0, false}}, {{1, 2}, {40, 1000, 0.04, false}}, {{1, 3}, {100, 1000, 0.1, false}}};
  cv::Mat masks(10, 10, CV_16UC1, cv::Scalar(0));
  masks.row(0).setTo(4);
  masks.row(1).setTo(9);
  const std::vector<std::string> expected = {"#2: lost",
                                             "#3: no mask",
                                             "#4: no state from a mask of 10 px",
                                             "#7: lost",
                                             "#8: lost",
                                             "#9: never a state; mask of 10 px",
                                             "ball (truth): out of view",
                                             "cube (truth): hidden, 4 % seen"};
  EXPECT_EQ(absence_notes(estimate, masks, 1, 100'000'000, truth, visibility), expected);
  EXPECT_EQ(absence_notes(estimate, cv::Mat(), 1, 100'000'000, {}, {}),
            (std::vector<std::string>{"#2: lost", "#3: no masks in this frame", "#4: no masks in this frame",
                                      "#7: lost", "#8: lost"}));
  EXPECT_EQ(absence_notes(estimate, masks, 0, kLate_ns, {}, {}).at(0), "no camera pose");
}

}  // namespace
}  // namespace uniquadric
