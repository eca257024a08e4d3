#include "estimator/plausibility/calibration_checks.h"

#include <fmt/format.h>

#include <cmath>

#include "estimator/plausibility/self_calibration.h"

namespace uniquadric {
namespace {

constexpr double kSquare = 0.1;       // of fx over fy, logarithm: pixels are square
constexpr double kNearMiddle = 0.05;  // of the image's side
constexpr double kOffMiddle = 0.2;    // of the image's side, of a principal point
constexpr double kFocalOff = 0.08;    // logarithm
constexpr double kSigmas = 5, kMostSigma = 0.03;
constexpr double kAlike = 0.6;                                 // both focal lengths' change, as a share of it
constexpr double kCentreOff = 0.07, kMostCentreSigma = 0.015;  // of the image's side
constexpr std::size_t kLeastPairs = 6;
constexpr double kLeastShare = 0.4;

bool is_near(double place, double side) {
  return std::abs(place / side - 0.5) < kNearMiddle;
}

std::vector<std::string> unusual(const Camera& c) {
  std::vector<std::string> found;
  if (std::abs(std::log(c.fx / c.fy)) > kSquare)
    found.push_back(fmt::format("fx: {} is unlike fy: {}, as of no square pixels", c.fx, c.fy));
  const bool is_off =
      std::abs(c.cx / c.width - 0.5) > kOffMiddle || std::abs(c.cy / c.height - 0.5) > kOffMiddle;
  if (is_near(c.cx, c.height) && is_near(c.cy, c.width) &&
      !(is_near(c.cx, c.width) && is_near(c.cy, c.height)))
    found.push_back(
        fmt::format("cx: {} and cy: {} look swapped for an image of {}x{}", c.cx, c.cy, c.width, c.height));
  else if (is_off)
    found.push_back(
        fmt::format("cx: {}, cy: {} lie far from the middle of an image of {}x{}: of another size?", c.cx,
                    c.cy, c.width, c.height));
  return found;
}

// What the motion of points with depth says against the stated intrinsics; empty for nothing.
std::string contradiction(const Camera& camera, const SelfCalibration& fit) {
  const double focal = 0.5 * (fit.log_fx + fit.log_fy), sigma = std::max(fit.sigma[0], fit.sigma[1]);
  const bool is_one = std::abs(fit.log_fx - fit.log_fy) < kAlike * std::abs(focal);
  if (is_one && sigma < kMostSigma && std::abs(focal) > std::max(kFocalOff, kSigmas * sigma))
    return fmt::format("fx, fy: points with depth move as with {:.2f} times the focal length",
                       std::exp(focal));
  const auto is_off = [](double off_px, double sigma_px, int side_px) {
    return sigma_px < kMostCentreSigma * side_px &&
           std::abs(off_px) > std::max(kCentreOff * side_px, kSigmas * sigma_px);
  };
  if (is_off(fit.cx_px, fit.sigma[2], camera.width))
    return fmt::format("cx: {}: points with depth move as with {:.0f}", camera.cx, camera.cx + fit.cx_px);
  if (is_off(fit.cy_px, fit.sigma[3], camera.height))
    return fmt::format("cy: {}: points with depth move as with {:.0f}", camera.cy, camera.cy + fit.cy_px);
  return "";
}

}  // namespace

std::vector<std::string> intrinsic_suspicions(const Sequence& sequence, const std::vector<FramePair>& pairs) {
  if (sequence.frames.empty()) return {};
  std::vector<std::string> found = unusual(sequence.camera);
  std::vector<const FramePair*> usable;
  for (const FramePair& pair : pairs)
    if (pair.b_from_a && pair.share >= kLeastShare) usable.push_back(&pair);
  if (found.empty() && usable.size() >= kLeastPairs)
    if (const auto fit = self_calibrate(sequence.camera, usable))
      if (const std::string text = contradiction(sequence.camera, *fit); !text.empty()) found.push_back(text);
  for (std::string& text : found) text = (sequence.folder / "sequence.yaml").string() + ": " + text;
  return found;
}

}  // namespace uniquadric
