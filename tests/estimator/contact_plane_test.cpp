#include "estimator/perception/contact_plane.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "tests/estimator/box_scene.h"

namespace uniquadric {
namespace {

const Camera kCamera{640, 480, 525, 525, 319.5, 239.5};
const Pose kView = look_at({0.9, -0.7, 0.9}, {0, 0, 0.1});

OrientedBox box_at(double bottom_m) {
  OrientedBox box;
  box.half_extents_m = {0.1, 0.06, 0.08};
  box.center = {0.02, 0.05, bottom_m + 0.08};
  box.axes = exp_so3({0, 0, 0.4}).toRotationMatrix();
  return box;
}

std::optional<ContactPlane> contact_of(double bottom_m, const ContactOptions& options = {}) {
  RandomStream pixels(1, "pixels"), random(1, "contact");
  const BoxImage image = render_box(kCamera, kView, box_at(bottom_m), pixels);
  cv::Mat depth;
  image.depth.convertTo(depth, CV_32FC1, 1 / 5000.0);
  return contact_plane(depth, image.mask, 1, kCamera, options, random);
}

TEST(ContactPlane, IsTheFloorThatABoxStandsOn) {
  const auto contact = contact_of(0);
  ASSERT_TRUE(contact);
  const Eigen::Vector3d up_in_camera = kView.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_LT(contact->normal.cross(up_in_camera).norm(), 2e-3);
  EXPECT_GT(contact->normal.dot(up_in_camera), 0);
  EXPECT_NEAR(contact->offset_m, kView.translation.z(), 2e-3);
}

TEST(ContactPlane, IsNoneUnderABoxInTheAir) {
  EXPECT_FALSE(contact_of(0.1));
  EXPECT_FALSE(contact_of(0, {.enabled = false}));
}

}  // namespace
}  // namespace uniquadric
