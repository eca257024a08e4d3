#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/sequence/sequence.h"

namespace uniquadric {

/// Verifies a sequence folder (or the folder that holds it beside its truth) and, where there is a sibling
/// `truth`, that too; a truth folder with its sibling `sequence`, or alone as far as that goes: a line for
/// each thing that is wrong, naming the file; none when all is well.
/// - that it opens (schema, lists, stamps), frame rate, calibration, files that no list names
/// - every image decodes and has the camera's type and size; depth is there and not cut off at 16 bits
/// - LiDAR scans can be read, their points' times lie within the scan and span it, their stamps lie within
/// the
///   sequence
/// - the IMU's rate is regular, its samples cover the frames and the scans, and their means fit their units
/// - truth and sequence have the same frames (of a recording: the truth's are among them), calibration and
///   objects; masks hold known ids only, exact masks
///   as many pixels as visibility.csv says
/// - `hashes.txt` of either folder
std::vector<std::string> check_sequence(const std::filesystem::path& folder);

/// What in a sequence folder (or the folder that holds it) is well-formed but hardly right
/// (estimator/plausibility); nothing of other folders, and of a sequence that does not open.
std::vector<std::string> check_plausibility(const std::filesystem::path& folder);

/// The part of the truth, `problems` being added to. `folder` is the truth's.
void check_truth(const Sequence& sequence, const std::filesystem::path& folder,
                 std::vector<std::string>& problems);

}  // namespace uniquadric
