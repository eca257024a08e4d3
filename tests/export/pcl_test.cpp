// Clouds as another library reads them: PCL's readers of PLY and PCD.
#include <pcl/PCLPointCloud2.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <algorithm>
#include <cstring>
#include <opencv2/core.hpp>

#include "core/sequence/lidar.h"
#include "tests/export/exported_scene.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

template <typename T>
T value(const pcl::PCLPointCloud2& cloud, const std::string& field, std::size_t point) {
  const auto found = std::find_if(cloud.fields.begin(), cloud.fields.end(),
                                  [&](const pcl::PCLPointField& f) { return f.name == field; });
  if (found == cloud.fields.end()) {
    ADD_FAILURE() << "no field " << field;
    return {};
  }
  T read;
  std::memcpy(&read, cloud.data.data() + point * cloud.point_step + found->offset, sizeof read);
  return read;
}

void expect_points(const pcl::PCLPointCloud2& cloud, const std::vector<LidarPoint>& points,
                   const std::string& offset_field) {
  ASSERT_EQ(cloud.width * cloud.height, points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(value<float>(cloud, "x", i), points[i].x);
    EXPECT_EQ(value<float>(cloud, "y", i), points[i].y);
    EXPECT_EQ(value<float>(cloud, "z", i), points[i].z);
    EXPECT_EQ(value<float>(cloud, "intensity", i), points[i].intensity);
    EXPECT_EQ(value<std::uint32_t>(cloud, offset_field, i), points[i].offset_ns);
    EXPECT_EQ(value<std::uint16_t>(cloud, "ring", i), points[i].ring);
    EXPECT_EQ(value<std::uint8_t>(cloud, "tag", i), points[i].tag);
  }
}

TEST_F(Export, PclReadsTheScansOfPly) {
  const fs::path out = run("ply");
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    pcl::PCLPointCloud2 cloud;
    ASSERT_EQ(pcl::PLYReader().read((out / ("lidar/00000" + std::to_string(i) + ".ply")).string(), cloud), 0);
    expect_points(cloud, scans_[i], "offset_ns");
  }
}

TEST_F(Export, PclReadsTheSequencesOwnScansAsPcd) {
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    pcl::PCLPointCloud2 cloud;
    ASSERT_EQ(pcl::PCDReader().read((sequence_.folder / sequence_.scans[i].file).string(), cloud), 0);
    expect_points(cloud, scans_[i], "offset_time");
    expect_points(cloud, scans_[i], "t");
  }
}

// PCL's own binary files come back the same, also with the zeros that it leaves at a page's end.
TEST_F(Export, ScansThatPclWroteAreRead) {
  pcl::PCLPointCloud2 cloud;
  ASSERT_EQ(pcl::PCDReader().read((sequence_.folder / sequence_.scans[0].file).string(), cloud), 0);
  const TempFolder temp;
  const fs::path written = temp.path() / "pcl.pcd";
  ASSERT_EQ(pcl::PCDWriter().writeBinary(written.string(), cloud), 0);
  for (const bool padded : {false, true}) {
    if (padded) fs::resize_file(written, (fs::file_size(written) / 4096 + 1) * 4096);
    expect_points(cloud, read_lidar_points(written), "offset_time");
  }
}

// The ball stands still: what the cloud has of it lies on its sphere, within the depth's noise.
TEST_F(Export, PclReadsTheFusedDepthOfPly) {
  ExportOptions options;
  options.frame_stride = options.pixel_stride = 1;
  pcl::PCLPointCloud2 cloud;
  ASSERT_EQ(pcl::PLYReader().read((run("ply", options) / "depth.ply").string(), cloud), 0);
  std::size_t pixels = 0;
  for (const SequenceFrame& frame : sequence_.frames)
    pixels += static_cast<std::size_t>(cv::countNonZero(sequence_image(frame.depth)));
  ASSERT_EQ(cloud.width * cloud.height, pixels);
  const Ellipsoid& ball = truth_of(kBall, 0).ellipsoid;
  int on_ball = 0;
  double sum_m = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (value<std::uint16_t>(cloud, "instance", i) != kBall) continue;
    const Eigen::Vector3f p(value<float>(cloud, "x", i), value<float>(cloud, "y", i),
                            value<float>(cloud, "z", i));
    const Eigen::Vector3d from_center = p.cast<double>() - ball.world_from_object.translation;
    EXPECT_NEAR(from_center.norm(), ball.semi_axes_m.x(), 0.06) << i;  // 5 sigma of 0.5 % at 2 m, and more
    sum_m += from_center.norm() - ball.semi_axes_m.x();
    ++on_ball;
  }
  EXPECT_GT(on_ball, 500);
  EXPECT_LT(std::abs(sum_m / on_ball), 0.002);
}

}  // namespace
}  // namespace uniquadric
