#pragma once

#include <span>

#include "core/base/random.h"

namespace uniquadric {

/// Fills `values` with independent standard normal numbers, some ten times faster than
/// RandomStream::normal(): 16 random bits choose one of 4096 equally probable cells of the normal
/// distribution and one of 16 places in it; the two outermost cells, which reach to infinity, are drawn by
/// Marsaglia's exact tail method ("Generating a variable from the tail of the normal distribution",
/// Technometrics 1964). Within a cell the density is taken as constant: the standard deviation is right to
/// 1e-4.
void fill_normals(RandomStream& stream, std::span<float> values);

/// Standard normal distribution function and its inverse, p in (0, 1).
double normal_cdf(double x);
double normal_quantile(double p);

}  // namespace uniquadric
