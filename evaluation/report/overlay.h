#pragma once

#include <filesystem>
#include <string>

namespace uniquadric {

/// Draws `count` evenly spaced frames (the first and the last among them) to `out`/NNNNNN.jpg, 640 px wide:
/// the segmenter's masks tinted, the outlines of the true bodies green (ellipsoids and cylinders as such, all
/// else as its tight box with its edges; where the estimate has ellipsoids alone, the ellipsoid within too),
/// of the estimated bodies orange, ellipsoids with their rotated rectangle, the edges of the estimated boxes
/// yellow; in the corner why an object has no state (absence.h). An estimate's own
/// masks (`estimate`/masks/NNNNNN.png) come before the sequence's. Objects whose projection is no ellipse
/// are not outlined. `truth` may be empty (recordings). Also writes `out`/sheet.jpg, all of them in one grid.
/// Throws InputError for folders that cannot be read or that are of two scenes (require_one_scene), and for
/// an `out` that exists, unless `force` replaces it. With a `color` ("#rrggbb", else InputError) the truth is
/// white and the estimates and their boxes have this colour, as in the report.
void write_overlays(const std::filesystem::path& sequence, const std::filesystem::path& truth,
                    const std::filesystem::path& estimate, const std::filesystem::path& out, int count,
                    bool force, const std::string& color = "");

/// All NNNNNN.jpg of a folder in one grid picture, in order of their names. Throws InputError when there is
/// none or one cannot be read.
void write_contact_sheet(const std::filesystem::path& overlays, const std::filesystem::path& picture);

}  // namespace uniquadric
