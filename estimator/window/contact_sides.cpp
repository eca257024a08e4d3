#include "estimator/window/contact_sides.h"

#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

// Ours: that errors which all pixels of a view share are as large as this share of one pixel's.
constexpr double kSharedNoise = 0.2;
constexpr double kLeastShare =
    0.25;  // of all views with contact, ours: fewer are an edge as the body tips over
constexpr double kCrossedShare = 0.1;  // of the points beyond a plane by kCrossedSigmas, ours: noise has less
constexpr double kCrossedSigmas = 3;
constexpr double kLeastTurn = 5e-3;  // [rad], ours: edges of real bodies are round

// Planes of one side, each by its outward direction and its place along that.
struct Group {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> directions;
  std::vector<double> positions_m, noises_m;
};

ContactSide side_of(const Group& group) {
  ContactSide side;
  side.direction = group.sum.normalized();
  side.position_m = upper_median(group.positions_m);
  std::vector<double> off, turned;
  for (std::size_t i = 0; i < group.directions.size(); ++i) {
    off.push_back(std::abs(group.positions_m[i] - side.position_m));
    turned.push_back(side.direction.cross(group.directions[i]).norm());
  }
  side.sigma_m = std::hypot(kMadToSigma * upper_median(off), kSharedNoise * upper_median(group.noises_m));
  side.sigma_rad = std::max(kLeastTurn, upper_median(turned));
  return side;
}

}  // namespace

std::vector<ContactSide> contact_sides(const std::vector<ShapeView>& views) {
  std::vector<Group> groups;
  for (const ShapeView& view : views) {
    if (!view.contact) continue;
    const Pose body_from_camera = view.world_from_body.inverse() * view.world_from_camera;
    const Eigen::Vector3d direction = -(body_from_camera.rotation * view.contact->normal);
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
      return g.sum.normalized().dot(direction) > kSameSideCosine;
    });
    if (group == groups.end()) group = groups.emplace(groups.end());
    group->sum += direction;
    group->directions.push_back(direction);
    group->positions_m.push_back(view.contact->offset_m + direction.dot(body_from_camera.translation));
    group->noises_m.push_back(view.contact->noise_m);
  }
  std::size_t all = 0;
  for (const Group& group : groups) all += group.directions.size();
  const double enough = std::max<double>(kLeastContactViews, kLeastShare * static_cast<double>(all));
  std::vector<ContactSide> sides;
  for (const Group& group : groups)
    if (static_cast<double>(group.directions.size()) >= enough) sides.push_back(side_of(group));
  return sides;
}

void drop_crossed(std::vector<ContactSide>& sides, const Eigen::Matrix3Xd& points) {
  std::erase_if(sides, [&](const ContactSide& side) {
    const Eigen::ArrayXd beyond_m = (side.direction.transpose() * points).array() - side.position_m;
    const auto crossed = (beyond_m > kCrossedSigmas * side.sigma_m).count();
    return static_cast<double>(crossed) > kCrossedShare * static_cast<double>(points.cols());
  });
}

}  // namespace uniquadric
