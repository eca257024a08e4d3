#include "simulator/lidar/point_truth.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/sequence/pcd.h"

namespace uniquadric {

void write_point_truth(const std::filesystem::path& path, const std::vector<LidarPointTruth>& truth,
                       const Pose& world_from_lidar) {
  PcdFile file;
  file.fields = {{"range"}, {"incidence_cos"}, {"instance", 2, 'U'}, {"kind", 1, 'U'}};
  file.points = static_cast<std::int64_t>(truth.size());
  file.viewpoint = world_from_lidar;
  for (const LidarPointTruth& t : truth) {
    file.put(t.range_m);
    file.put(t.incidence_cos);
    file.put(t.instance);
    file.put(static_cast<std::uint8_t>(t.kind));
  }
  write_pcd(path, file);
}

std::vector<LidarPointTruth> read_point_truth(const std::filesystem::path& path) {
  const PcdFile file = read_pcd(path);
  const PcdColumn range = pcd_column(path, file, "range", 'F', 4),
                  cosine = pcd_column(path, file, "incidence_cos", 'F', 4),
                  instance = pcd_column(path, file, "instance", 'U', 2),
                  kind = pcd_column(path, file, "kind", 'U', 1);
  std::vector<LidarPointTruth> truth;
  for (std::int64_t i = 0; i < file.points; ++i) {
    const auto what = kind.at<std::uint8_t>(i);
    if (what > static_cast<std::uint8_t>(LidarPointTruth::Kind::false_alarm))
      throw InputError(path, fmt::format("point {}: kind {} is none of 0, 1, 2", i, what));
    truth.push_back({range.at<float>(i), cosine.at<float>(i), instance.at<std::uint16_t>(i),
                     static_cast<LidarPointTruth::Kind>(what)});
  }
  return truth;
}

}  // namespace uniquadric
