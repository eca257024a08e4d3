// The smallest estimator in C++: one upright box for each mask of each frame, by the libraries of core.
// usage: minimal_cpp SEQUENCE OUT
#include <Eigen/Geometry>
#include <filesystem>
#include <iostream>
#include <map>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"

using namespace uniquadric;

// The box, along the world's axes, of the points under each mask.
std::map<int, Eigen::AlignedBox3d> boxes(const Sequence& sequence, const SequenceFrame& frame,
                                         const Pose& world_from_camera) {
  const cv::Mat depth = read_depth(sequence, frame), masks = read_masks(sequence, frame);
  std::map<int, Eigen::AlignedBox3d> boxes;
  for (int v = 0; v < masks.rows; ++v)
    for (int u = 0; u < masks.cols; ++u) {
      const int id = masks.at<std::uint16_t>(v, u);
      const double z = depth.at<float>(v, u);
      if (id == 0 || !(z > 0)) continue;
      if (const auto ray = sequence.camera.unproject({u, v}))
        boxes[id].extend(world_from_camera * (z * *ray).eval());
    }
  return boxes;
}

int main(int argc, char** argv) try {
  if (argc != 3) throw InputError("usage: minimal_cpp SEQUENCE OUT");
  const Sequence sequence = open_sequence(argv[1]);
  if (!sequence.given_camera) throw InputError(argv[1], "has no camera poses");
  std::map<std::int64_t, Pose> world_from_camera;
  for (const StampedPose& pose : *sequence.given_camera) world_from_camera[pose.stamp_ns] = pose.pose;
  Tracks tracks;
  tracks.camera = *sequence.given_camera;
  std::map<int, ObjectTrack> by_id;
  for (const SequenceFrame& frame : sequence.frames) {
    const auto pose = world_from_camera.find(frame.stamp_ns);
    if (frame.depth.empty() || frame.masks.empty() || pose == world_from_camera.end()) continue;
    for (const auto& [id, box] : boxes(sequence, frame, pose->second)) {
      if (!(box.sizes().minCoeff() > 0)) continue;
      ObjectState& state = by_id[id].states.emplace_back();
      state.frame = frame.frame;
      state.stamp_ns = frame.stamp_ns;
      state.ellipsoid.world_from_object.translation = box.center();
      state.ellipsoid.semi_axes_m = box.sizes() / 2;
      state.exponents = {1, 1, 1};  // a box
    }
  }
  for (auto& [id, track] : by_id) {
    track.id = id;
    tracks.objects.push_back(track);
  }
  std::filesystem::create_directories(argv[2]);
  write_estimate(argv[2], tracks);
} catch (const std::exception& e) {
  std::cerr << "minimal_cpp: " << e.what() << '\n';
  return 2;
}
