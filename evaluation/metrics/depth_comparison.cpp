#include "evaluation/metrics/depth_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "core/base/error.h"
#include "core/sequence/depth_scale.h"
#include "core/sequence/sequence.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

bool is_measured(std::uint16_t depth) {
  return depth != 0 && depth != kDepthCutOff;
}

cv::Mat read_16_bit(const fs::path& path) {
  cv::Mat image = read_image(path);
  if (image.type() != CV_16UC1) throw InputError(path, "is no 16-bit image of one channel");
  return image;
}

cv::Mat read_16_bit(const fs::path& path, const cv::Mat& other) {
  cv::Mat image = read_16_bit(path);
  if (image.size() != other.size())
    throw InputError(
        path, fmt::format("is {}x{}, the true depth {}x{}", image.cols, image.rows, other.cols, other.rows));
  return image;
}

// Names of a folder's PNG images; of a file one empty name.
std::vector<fs::path> names_of(const fs::path& path) {
  if (!fs::is_directory(path)) return {fs::path()};
  std::vector<fs::path> names;
  for (const auto& entry : fs::directory_iterator(path))
    if (entry.path().extension() == ".png") names.push_back(entry.path().filename());
  if (names.empty()) throw InputError(path, "has no PNG images");
  std::sort(names.begin(), names.end());
  return names;
}

fs::path at(const fs::path& file_or_folder, const fs::path& name) {
  return name.empty() ? file_or_folder : file_or_folder / name;
}

double scale_of(const fs::path& images, std::optional<double> otherwise) {
  if (const auto stated = stated_depth_units_per_m(images)) return *stated;
  if (otherwise) return *otherwise;
  throw InputError(images, "no sequence.yaml beside it or above says its depth.units_per_m: --scale says it");
}

void set_scales(const fs::path& truth, const fs::path& estimate, std::optional<double> option,
                DepthComparison& comparison) {
  comparison.true_units_per_m = scale_of(truth, option);
  comparison.estimate_units_per_m = scale_of(estimate, option);
  if (option && comparison.true_units_per_m != *option && comparison.estimate_units_per_m != *option)
    throw InputError(
        fmt::format("--scale {}: the images' sequence.yaml says {}", *option, comparison.true_units_per_m));
}

// Differences are counted by their size in the coarser of the two units, in which all of them are below
// 65535: so memory does not grow with the images. Of one unit on both sides they are whole, and exact.
struct Sums {
  DepthComparison result;
  double coarse_units_per_m = std::min(result.true_units_per_m, result.estimate_units_per_m);
  std::vector<std::uint64_t> differences = std::vector<std::uint64_t>(kDepthCutOff);
  double squares = 0, relative = 0;
  std::uint64_t near = 0;

  void add(std::uint16_t true_value, std::uint16_t estimated_value) {
    if (!is_measured(true_value)) return;
    ++result.true_pixels;
    if (!is_measured(estimated_value)) return;
    ++result.compared_pixels;
    const double truth = true_value * (coarse_units_per_m / result.true_units_per_m);
    const double estimate = estimated_value * (coarse_units_per_m / result.estimate_units_per_m);
    const double difference = std::abs(estimate - truth);
    ++differences[static_cast<std::size_t>(std::lround(difference))];
    squares += difference * difference;
    relative += difference / truth;
    if (4 * std::max(estimate, truth) < 5 * std::min(estimate, truth)) ++near;
  }

  int ranked(std::uint64_t rank) const {
    int size = 0;
    for (std::uint64_t seen = differences[0]; seen <= rank;
         seen += differences[static_cast<std::size_t>(size)])
      ++size;
    return size;
  }

  DepthComparison finish() const {
    DepthComparison c = result;
    if (c.compared_pixels == 0) return c;
    const auto n = static_cast<double>(c.compared_pixels);
    c.rmse_m = std::sqrt(squares / n) / coarse_units_per_m;
    c.median_m =
        0.5 * (ranked((c.compared_pixels - 1) / 2) + ranked(c.compared_pixels / 2)) / coarse_units_per_m;
    c.relative_error = relative / n;
    c.share_within_a_quarter = share(near, c.compared_pixels);
    return c;
  }
};

}  // namespace

DepthComparison compare_depth(const fs::path& truth, const fs::path& estimate, const DepthOptions& options) {
  if (fs::is_directory(truth) != fs::is_directory(estimate))
    throw InputError(estimate, fmt::format("and {}: one is a folder, one is not", truth.string()));
  if (options.masks.empty() == options.id.has_value()) throw InputError("an id goes with masks of ids");
  DepthComparison scales;
  set_scales(truth, estimate, options.units_per_m, scales);
  Sums sums{scales};
  for (const fs::path& name : names_of(truth)) {
    const cv::Mat depth = read_16_bit(at(truth, name));
    ++sums.result.images;
    cv::Mat other = cv::Mat::zeros(depth.size(), CV_16UC1), ids;
    if (!name.empty() && !fs::exists(estimate / name))
      ++sums.result.missing_images;
    else
      other = read_16_bit(at(estimate, name), depth);
    if (options.id) ids = read_16_bit(at(options.masks, name), depth);
    for (int v = 0; v < depth.rows; ++v)
      for (int u = 0; u < depth.cols; ++u)
        if (!options.id || ids.at<std::uint16_t>(v, u) == *options.id)
          sums.add(depth.at<std::uint16_t>(v, u), other.at<std::uint16_t>(v, u));
  }
  if (sums.result.missing_images == sums.result.images)
    throw InputError(estimate, fmt::format("has none of the images of {}", truth.string()));
  if (sums.result.true_pixels == 0 && options.id)
    throw InputError(options.masks, fmt::format("no true depth under the id {}", *options.id));
  if (sums.result.true_pixels == 0) throw InputError(truth, "has no depth");
  return sums.finish();
}

Figures figures(const DepthComparison& c) {
  return {{"images", c.images},
          {"missing_images", c.missing_images},
          {"true_pixels", c.true_pixels},
          {"n", c.compared_pixels},
          {"coverage", share(c.compared_pixels, c.true_pixels)},
          {"rmse_m", c.rmse_m},
          {"median_m", c.median_m},
          {"absolute_relative_error", c.relative_error},
          {"delta_1", c.share_within_a_quarter},
          {"true_units_per_m", c.true_units_per_m},
          {"estimate_units_per_m", c.estimate_units_per_m}};
}

}  // namespace uniquadric
