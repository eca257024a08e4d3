#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "evaluation/metrics/figures.h"

namespace uniquadric {

struct DepthOptions {
  std::optional<double> units_per_m{};  ///< value of a pixel at 1 m, of images beside no sequence.yaml
  std::filesystem::path masks{};        ///< of ids: a file, or a folder as the images' are; empty: all pixels
  std::optional<std::uint16_t> id{};    ///< whose pixels count, with `masks`
};

struct DepthComparison {
  double true_units_per_m = 0, estimate_units_per_m = 0;
  std::uint64_t images = 0, missing_images = 0;  ///< missing: of the estimate; counted as no measurement
  std::uint64_t true_pixels = 0, compared_pixels = 0;  ///< that have a true depth; and an estimate
  /// Of compared pixels, nothing of none. Difference e - t of estimate and truth:
  std::optional<double> rmse_m, median_m;        ///< of |e - t|; the median to half the coarser unit
  std::optional<double> relative_error;          ///< mean of |e - t| / t
  std::optional<double> share_within_a_quarter;  ///< in which max(e / t, t / e) < 1.25 (delta_1)
};

/// Compares two depth images, or the images of a folder with those of the same names in another (16-bit PNG;
/// 0 and 65535 are no measurement). Each side's scale is that of its sequence.yaml
/// (stated_depth_units_per_m), else the option's. Throws InputError naming the file for what is no such
/// image, sizes that differ, a folder against a file, no name in common, no true depth at all, or none under
/// the id, and a scale that is said by neither, or by the option otherwise than by the files of both sides.
DepthComparison compare_depth(const std::filesystem::path& truth, const std::filesystem::path& estimate,
                              const DepthOptions& options);

Figures figures(const DepthComparison& comparison);

}  // namespace uniquadric
