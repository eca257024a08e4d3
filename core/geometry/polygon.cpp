#include "core/geometry/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace uniquadric {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

class EarCutter {
 public:
  explicit EarCutter(const std::vector<Eigen::Vector3f>& corners) : corners_(corners), left_(corners.size()) {
    std::iota(left_.begin(), left_.end(), 0U);
    for (std::uint32_t i = 2; i < corners.size(); ++i) area_ += area({0, i - 1, i});
  }

  std::vector<Triangle> cut() {
    std::vector<Triangle> triangles;
    while (left_.size() > 2) {
      std::size_t tip = 1;
      while (tip < left_.size() && !is_ear(at(tip))) ++tip;
      if (tip == left_.size()) tip = 1;  // only of a polygon that cuts itself or is flat
      triangles.push_back(at(tip));
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(tip));
    }
    return triangles;
  }

 private:
  Eigen::Vector3d corner(std::uint32_t i) const { return corners_[i].cast<double>(); }
  Eigen::Vector3d area(const Triangle& t) const {
    return (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0]));
  }
  Triangle at(std::size_t tip) const { return {left_[tip - 1], left_[tip], left_[(tip + 1) % left_.size()]}; }
  bool turns_left(const Triangle& t) const { return area(t).dot(area_) > 0; }
  bool is_ear(const Triangle& t) const {
    return turns_left(t) && std::ranges::none_of(left_, [&](std::uint32_t i) {
             return turns_left({t[0], t[1], i}) && turns_left({t[1], t[2], i}) && turns_left({t[2], t[0], i});
           });
  }

  const std::vector<Eigen::Vector3f>& corners_;
  std::vector<std::uint32_t> left_;
  Eigen::Vector3d area_ = Eigen::Vector3d::Zero();
};

}  // namespace

std::vector<Triangle> triangulate(const std::vector<Eigen::Vector3f>& corners) {
  return EarCutter(corners).cut();
}

}  // namespace uniquadric
