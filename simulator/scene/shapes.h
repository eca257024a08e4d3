#pragma once

#include <Eigen/Core>
#include <vector>

#include "simulator/scene/mesh.h"
#include "simulator/scene/texture.h"

namespace uniquadric {

/// Bodies made by the program. All are centred at the origin, their tight box measures `size_m` (full extents
/// x, y, z [m], to single precision), closed, wound counter-clockwise seen from outside.

struct RoundedBoxOptions {
  double radius_m = 0.02;     ///< of edges and corners; 0 is a sharp box; at most half the least extent
  double recess_depth_m = 0;  ///< of a rectangular recess in each of the six faces; 0: none
  double recess_share = 0.6;  ///< side of the recess over the side of the face's flat part
  int segments = 6;           ///< of a rounded edge per 45 degrees
};
std::vector<Mesh> rounded_box(const Eigen::Vector3d& size_m, const RoundedBoxOptions& options,
                              const Material& material);

/// A sphere of six panels, stretched to `size_m`: ball and ellipsoid. The facets lie inside the true surface
/// by at most 1 - cos(45 deg / segments) of the radius.
std::vector<Mesh> ellipsoid(const Eigen::Vector3d& size_m, int segments, const Material& material);

/// Axis along z; `segments` around, a multiple of 4.
std::vector<Mesh> cylinder(const Eigen::Vector3d& size_m, int segments, const Material& material);

/// Deck with raised nose and tail along x, two trucks, four wheels; z up.
std::vector<Mesh> skateboard(const Eigen::Vector3d& size_m, const Material& material);

/// A saloon car along x: body, cabin, four wheels; z up.
std::vector<Mesh> car(const Eigen::Vector3d& size_m, const Material& material);

/// A subway carriage along x: body with recessed door bays, underframe, bogies, roof units; z up.
std::vector<Mesh> carriage(const Eigen::Vector3d& size_m, const Material& material);

/// A mug along z: its handle points to +x.
std::vector<Mesh> mug(const Eigen::Vector3d& size_m, const Material& material);

/// A bowl along z, wider above.
std::vector<Mesh> bowl(const Eigen::Vector3d& size_m, const Material& material);

/// An L in x and z, drawn out along y; `thickness` of its arms as a share of the extents, below 1.
std::vector<Mesh> angle(const Eigen::Vector3d& size_m, double thickness, const Material& material);

/// A walker along x, z up, in mid-stride: rigid.
std::vector<Mesh> pedestrian(const Eigen::Vector3d& size_m, const Material& material);

/// A cyclist along x, z up: two wheels, a frame, a rigid rider.
std::vector<Mesh> cyclist(const Eigen::Vector3d& size_m, const Material& material);

/// A flat sheet of size_m x, y facing +z (seen from one side only).
std::vector<Mesh> plane(const Eigen::Vector2d& size_m, const Material& material);

/// The inside of a room (floor, ceiling, four walls, facing inwards) with `furniture` boxes along its walls.
std::vector<Mesh> room(const Eigen::Vector3d& size_m, int furniture, const Material& material);

/// Across a street: depth of its houses, width of its pavements, height of its kerbs.
inline constexpr double kHouse_m = 3, kPavement_m = 4, kKerbHeight_m = 0.15;

/// A street along x under the open sky: `size_m` is its length, its width from back to back of the houses,
/// and the height of the tallest. Road and pavements, rows of houses on both sides and across both ends,
/// lamps, trees and kiosks on the pavements, with `parked_cars` cars at the kerb. The kerbs are 7 m from the
/// backs of the houses. Free for traffic: the width less 20 m, in the middle.
std::vector<Mesh> street(const Eigen::Vector3d& size_m, bool parked_cars, const Material& material);

/// Rails and sleepers along an arc about the origin, on z = 0; angles count from +x about +z.
struct TrackOptions {
  double radius_m = 100, from_rad = 0, to_rad = 0.5;
  double gauge_m = 1.435;  ///< between the rails' middles
};
std::vector<Mesh> track(const TrackOptions& options, const Material& material);

}  // namespace uniquadric
