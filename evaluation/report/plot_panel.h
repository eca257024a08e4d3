#pragma once

#include <string>
#include <vector>

#include "evaluation/report/picture.h"

namespace uniquadric {

/// An interval of values.
struct PlotRange {
  double min = 0, max = 1;
};

/// The range of values with room on both sides; of one value alone, room about it.
PlotRange padded_range(const std::vector<double>& values);

/// Round numbers (1, 2 or 5 times a power of ten apart) inside a range, about `count` of them.
std::vector<double> round_ticks(const PlotRange& range, int count);

/// A plot's frame inside a picture and what it shows.
struct PlotPanel {
  double left = 0, top = 0, width = 1, height = 1;  ///< of the plot itself, labels lie outside
  PlotRange x, y;

  double x_of(double value) const { return left + width * (value - x.min) / (x.max - x.min); }
  double y_of(double value) const { return top + height * (1 - (value - y.min) / (y.max - y.min)); }
};

/// Grid lines with their numbers, and the names of both axes.
void draw_axes(Picture& picture, const PlotPanel& panel, const std::string& x_name,
               const std::string& y_name);

/// A line through points of x and y, to a tenth of a unit; points that fall on the one before are left out.
std::vector<PicturePoint> panel_line(const PlotPanel& panel, const std::vector<double>& x,
                                     const std::vector<double>& y);

}  // namespace uniquadric
