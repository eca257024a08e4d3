#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "estimator/ego/depth_calibration.h"
#include "estimator/observation/perception.h"

namespace uniquadric {

inline constexpr const char* kMapFile = "map.ply";  ///< of a kept perception, and of an estimate

/// A part of a file, and the hash of what it holds.
struct FilePlace {
  std::uint64_t offset = 0, size = 0, hash = 0;
};

/// What a perception was made of.
struct PerceptionSource {
  std::string key;            ///< hash of all that it depends on: sequence, prompts, options, seed, code
  std::string sequence;       ///< the sequence's name
  std::string sequence_hash;  ///< hash of which one it is; empty in files made before there was one
};

/// Writes the perception stage's result frame by frame, so that no more than a frame of it is in memory:
/// perception.yaml, camera.yaml, camera.tum (the poses alone, for other tools) and observations.bin in an
/// existing folder.
class PerceptionWriter {
 public:
  /// `camera`: without distortion. `source` may be empty.
  PerceptionWriter(std::filesystem::path folder, const Camera& camera, PerceptionSource source);

  /// The next frame, without its poses. Throws std::runtime_error when it cannot
  /// be written.
  void add(const PerceivedFrame& frame);

  /// Keeps the map that the camera was followed by, in the poses' world (map.ply).
  void keep_map(const std::vector<Eigen::Vector3d>& points) const;

  /// To be called last. A frame without a pose in `camera.final` is one where the camera was lost.
  /// `ego_restarts`: how often a new map went on from the last known pose.
  /// `depth_bias`: that was taken out of the depth images; nothing: it was not looked for, or not found.
  /// `depth_edge_width_px`: of the ramps that were taken out of them; 1: there were none.
  void finish(const CameraTrajectories& camera, int ego_restarts = 0,
              const std::optional<DepthBias>& depth_bias = {}, double depth_edge_width_px = 1);

 private:
  void write(const std::string& bytes);

  std::filesystem::path folder_;
  Camera camera_;
  PerceptionSource source_;
  std::ofstream file_;
  std::uint64_t size_ = 0;  // of what has been written
  std::vector<FrameInfo> frames_;
  std::vector<FilePlace> places_;
};

/// A kept perception: all that the back end knows of the images. The bodies of a frame are read when asked
/// for, the same bits that were written.
class Perception {
 public:
  /// Throws InputError with file and line.
  explicit Perception(const std::filesystem::path& folder);

  const Camera& camera() const { return camera_; }  ///< without distortion
  const PerceptionSource& source() const { return source_; }
  const std::vector<FrameInfo>& frames() const { return frames_; }
  int ego_restarts() const { return ego_restarts_; }
  const std::optional<DepthBias>& depth_bias() const { return depth_bias_; }
  double depth_edge_width_px() const { return depth_edge_width_px_; }

  /// One frame with its bodies; from any thread. Throws InputError when the file is damaged.
  PerceivedFrame read(std::size_t index) const;

 private:
  std::filesystem::path file_;
  Camera camera_;
  PerceptionSource source_;
  std::vector<FrameInfo> frames_;
  std::vector<FilePlace> places_;
  int ego_restarts_ = 0;
  std::optional<DepthBias> depth_bias_;
  double depth_edge_width_px_ = 1;
};

/// What was taken out of the depth images: the lines `inverse_depth_bias_per_m` and
/// `inverse_depth_bias_sigma_per_m` [1/m], none for no bias, and `depth_edge_width_px`, none for sharp edges.
std::string depth_faults_yaml(const std::optional<DepthBias>& bias, double edge_width_px);

/// What lies in a folder (below it, in order) that no kept perception has.
std::vector<std::filesystem::path> foreign_files(const std::filesystem::path& folder);

/// What a kept perception was made of.
PerceptionSource perception_source_of(const std::filesystem::path& folder);

}  // namespace uniquadric
