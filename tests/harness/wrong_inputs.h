#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/sequence/sequence.h"

namespace uniquadric {

/// A sound sequence made wrong, but well-formed: as a usual mistake of who records or converts it would.
struct WrongInput {
  std::string name;
  std::function<void(Sequence&)> make;  ///< changes the sequence and files in its folder
};

/// Of a sequence with depth, masks, an IMU and given poses.
std::vector<WrongInput> wrong_camera_inputs();
/// Of a sequence with scans, an IMU and given poses, but without depth.
std::vector<WrongInput> wrong_scan_inputs();

/// A copy of the sequence `from` in `to`, without hashes, made wrong.
void write_wrong(const WrongInput& input, const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace uniquadric
