#pragma once

#include <Eigen/Core>
#include <optional>

namespace uniquadric {

/// Where a body ends along a line, from noisy points of its surface.
struct DensityEdge {
  double position_m = 0;
  double sigma_m = 0;  ///< standard error, as if the model of the density were true
  double noise_m = 0;  ///< sigma of the points about the surface, as fitted
};

struct DensityEdgeOptions {
  double start_density = 0.15;  // ours: of the body's mean density; outliers in a cube of 1 m stay below it
  double min_weight = 30;       // ours
};

/// The upper end of a body along a line: `coordinates` of surface points along it [m] with their weights (how
/// many measurements each stands for) and about noise_m of noise. The largest coordinate lies beyond the
/// surface by the noise's tail, 2.5 sigmas of 100 points. Here the density at the end is a sum of a face (all
/// points at the edge), a side (even up to the edge), a slope (rising up to it) and a bulge (falling as the
/// root of the depth below it), each cut at the edge and blurred by the noise, over an even floor of
/// outliers; the edge is that of the greatest likelihood. Nothing for too few points.
std::optional<DensityEdge> upper_edge(const Eigen::VectorXd& coordinates, const Eigen::VectorXd& weights,
                                      double noise_m, const DensityEdgeOptions& options = {});

}  // namespace uniquadric
