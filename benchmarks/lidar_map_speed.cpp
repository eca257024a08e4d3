// The odometry's map (cells in a hash) against PCL's kd-tree and octree of all its points: a sweep at a time,
// 1250 points placed on planes of the sweeps before, then added. Milliseconds a sweep.
// usage: lidar_map_speed
#include <fmt/format.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/octree/octree_search.h>

#include <Eigen/Eigenvalues>
#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "estimator/ego/lidar_map.h"

namespace uniquadric {
namespace {

constexpr int kSweeps = 200, kPoints = 1250, kNeighbours = 5;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;

// Of a street with walls 8 m to both sides, along which the sensor goes at 5 m/s, ten sweeps a second.
std::vector<Eigen::Vector3d> sweep(int index) {
  RandomStream random(1, "sweep", index);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kPoints; ++i) {
    const double along = 0.5 * index + random.uniform(-30, 30), off = 0.02 * random.normal();
    if (i % 3 == 0)
      points.emplace_back(along, random.uniform(-8, 8), off);
    else
      points.emplace_back(along, (i % 3 == 1 ? 8 : -8) + off, random.uniform(0, 6));
  }
  return points;
}

pcl::PointXYZ pcl_point(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

struct HashMap {
  LidarMap map{LidarMapOptions{}};
  bool has_plane(const Eigen::Vector3d& p) const { return map.plane_near(p, {0.2, 0.1}).has_value(); }
  void add(const std::vector<Eigen::Vector3d>& points) {
    for (const auto& p : points) map.add(p);
  }
};

template <typename Search>
bool has_plane_among(Search& search, const Cloud& cloud, const Eigen::Vector3d& p) {
  std::vector<int> found(kNeighbours);
  std::vector<float> squares(kNeighbours);
  if (cloud.empty() || search.nearestKSearch(pcl_point(p), kNeighbours, found, squares) < kNeighbours)
    return false;
  Eigen::Matrix3Xd near(3, kNeighbours);
  for (int i = 0; i < kNeighbours; ++i)
    near.col(i) =
        cloud[static_cast<std::size_t>(found[static_cast<std::size_t>(i)])].getVector3fMap().cast<double>();
  const Eigen::Vector3d mean = near.rowwise().mean();
  const Eigen::Matrix3Xd off = near.colwise() - mean;
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(off * off.transpose()).eigenvalues()[0] < 0.2;
}

// Built anew for each sweep: it takes no more points.
struct KdTree {
  Cloud::Ptr cloud = std::make_shared<Cloud>();
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  bool has_plane(const Eigen::Vector3d& p) const { return has_plane_among(tree, *cloud, p); }
  void add(const std::vector<Eigen::Vector3d>& points) {
    for (const auto& p : points) cloud->push_back(pcl_point(p));
    tree.setInputCloud(cloud);
  }
};

struct Octree {
  Cloud::Ptr cloud = std::make_shared<Cloud>();
  mutable pcl::octree::OctreePointCloudSearch<pcl::PointXYZ> tree{0.25};
  Octree() { tree.setInputCloud(cloud); }
  bool has_plane(const Eigen::Vector3d& p) const { return has_plane_among(tree, *cloud, p); }
  void add(const std::vector<Eigen::Vector3d>& points) {
    for (const auto& p : points) tree.addPointToCloud(pcl_point(p), cloud);
  }
};

template <typename Map>
void measure(const char* name) {
  Map map;
  fmt::print("{:<14}", name);
  double seconds = 0;
  int planes = 0;
  for (int i = 0; i < kSweeps; ++i) {
    const auto points = sweep(i);
    const auto start = std::chrono::steady_clock::now();
    for (const auto& p : points) planes += map.has_plane(p);
    map.add(points);
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if ((i + 1) % 50 == 0) fmt::print("{:8.2f}", 1e3 * std::exchange(seconds, 0) / 50);
  }
  fmt::print("   planes of {:.0f} %\n", 100.0 * planes / (kSweeps * kPoints));
}

}  // namespace
}  // namespace uniquadric

int main() {
  fmt::print("{:<14}{:>8}{:>8}{:>8}{:>8}\n", "sweeps", "1-50", "-100", "-150", "-200");
  uniquadric::measure<uniquadric::HashMap>("hash of cells");
  uniquadric::measure<uniquadric::KdTree>("PCL kd-tree");
  uniquadric::measure<uniquadric::Octree>("PCL octree");
}
