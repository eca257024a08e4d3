#include "core/sequence/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "core/sequence/calibration.h"
#include "core/sequence/file_list.h"
#include "core/sequence/smeared_edges.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kSequenceSchema = 1;

void associate_masks(const fs::path& folder, std::vector<SequenceFrame>& frames,
                     const std::vector<ListedFile>& masks) {
  std::map<std::int64_t, SequenceFrame*> frame_at;
  for (auto& frame : frames) frame_at[frame.stamp_ns] = &frame;
  for (const auto& entry : masks) {
    const auto found = frame_at.find(entry.stamp_ns);
    if (found == frame_at.end())
      throw InputError(folder / "masks.txt",
                       fmt::format("stamp {} is no frame of rgb.txt", format_stamp(entry.stamp_ns)));
    found->second->masks = entry.file;
    found->second->masks_arrival_ns = entry.arrival_ns;
  }
}

// Values of a 16-bit image besides 0.
int count_different(const cv::Mat& image) {
  std::vector<char> is_there(1 << 16);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) is_there[image.at<std::uint16_t>(v, u)] = 1;
  is_there[0] = 0;
  return static_cast<int>(std::count(is_there.begin(), is_there.end(), 1));
}

// At most a frame: an image is read out before the next one begins.
double read_rolling_shutter(const ConfigNode& camera, double rate_hz) {
  const double readout_s = camera.get<double>("rolling_shutter_s", 0);
  if (readout_s < 0)
    camera.at("rolling_shutter_s").fail(fmt::format("expected at least 0, found {}", readout_s));
  if (readout_s * rate_hz > 1)
    camera.at("rolling_shutter_s")
        .fail(fmt::format("is {} s, longer than a frame, {} s", readout_s, 1 / rate_hz));
  return readout_s;
}

std::string rolling_shutter_yaml(double readout_s) {
  return readout_s > 0 ? fmt::format(", rolling_shutter_s: {}", readout_s) : "";
}

cv::Mat read_of_kind(const Sequence& sequence, const fs::path& file, ImageKind kind) {
  const fs::path path = sequence.folder / file;
  const cv::Mat image = read_image(path);
  require_image(path, image, sequence.camera, kind);
  return image;
}

}  // namespace

Sequence open_sequence(const fs::path& given_folder) {
  if (!fs::is_directory(given_folder)) throw InputError(given_folder, "is not a folder");
  // A folder that `simulate` wrote holds the sequence beside its truth.
  const bool is_parent =
      !fs::exists(given_folder / "sequence.yaml") && fs::exists(given_folder / "sequence/sequence.yaml");
  const fs::path folder = is_parent ? given_folder / "sequence" : given_folder;
  const ConfigNode root = ConfigNode::load(folder / "sequence.yaml");
  if (const int schema = root.get<int>("schema"); schema != kSequenceSchema)
    root.at("schema").fail(
        fmt::format("version {} is not supported (this program reads {})", schema, kSequenceSchema));
  Sequence sequence;
  sequence.folder = folder;
  sequence.program = root.get<std::string>("program", "");
  sequence.name = root.get<std::string>("name");
  sequence.scene_hash = root.get<std::string>("scene_hash", "");
  sequence.seed = root.get<std::uint64_t>("seed", 0);
  if (root.has("realism")) sequence.realism = root.name("realism");
  const ConfigNode camera = root.at("camera");
  sequence.camera = read_camera(camera);
  sequence.rate_hz = camera.positive("rate_hz");
  sequence.rolling_shutter_s = read_rolling_shutter(camera, sequence.rate_hz);
  camera.refuse_unknown_keys();
  if (const auto depth = root.find("depth")) {
    sequence.depth_units_per_m = depth->positive("units_per_m");
    depth->refuse_unknown_keys();
  }
  if (const auto imu = root.find("imu")) sequence.imu = read_imu_calibration(*imu);
  if (const auto lidar = root.find("lidar")) sequence.lidar = read_lidar_calibration(*lidar);
  root.refuse_unknown_keys();

  const bool has_frames = !sequence.lidar || fs::exists(folder / "rgb.txt");  // a LiDAR may be alone
  for (const auto& entry :
       has_frames ? read_file_list(folder, "rgb.txt", false) : std::vector<ListedFile>()) {
    SequenceFrame frame;
    frame.frame = std::ssize(sequence.frames);
    frame.stamp_ns = entry.stamp_ns;
    frame.rgb = entry.file;
    sequence.frames.push_back(frame);
  }
  if (sequence.frames.empty() && !sequence.lidar) throw InputError(folder / "rgb.txt", "names no image");
  if (fs::exists(folder / "depth.txt")) {
    const std::vector<ListedFile> depth = read_file_list(folder, "depth.txt", false);
    if (depth.empty())
      throw InputError(folder / "depth.txt", "names no image; a sequence without depth has none");
    associate_depth(sequence.frames, depth);
  }
  if (fs::exists(folder / "masks.txt"))
    associate_masks(folder, sequence.frames, read_file_list(folder, "masks.txt", true));
  if (sequence.imu && !fs::exists(folder / "imu.csv"))
    throw InputError(folder / "imu.csv", "no such file, but sequence.yaml describes an IMU");
  if (sequence.lidar)
    for (const auto& entry : read_file_list(folder, "lidar.txt", false))
      sequence.scans.push_back({entry.stamp_ns, entry.file});
  if (sequence.frames.empty() && sequence.scans.empty())
    throw InputError(folder / "lidar.txt", "names no scan, and there are no images");
  if (fs::exists(folder / "camera_given.tum")) sequence.given_camera = read_tum(folder / "camera_given.tum");
  return sequence;
}

void write_sequence_index(const fs::path& folder, const Sequence& sequence) {
  std::string yaml = fmt::format("schema: {}\nprogram: {}\nname: {}\n", kSequenceSchema,
                                 yaml_quoted(sequence.program), yaml_quoted(sequence.name));
  if (!sequence.scene_hash.empty())
    yaml += fmt::format("scene_hash: \"{}\"\nseed: {}\n", sequence.scene_hash, sequence.seed);
  if (!sequence.realism.empty()) yaml += fmt::format("realism: {}\n", yaml_quoted(sequence.realism));
  yaml += fmt::format("camera: {{{}, rate_hz: {}{}}}\n", camera_yaml(sequence.camera), sequence.rate_hz,
                      rolling_shutter_yaml(sequence.rolling_shutter_s));
  yaml += fmt::format("depth: {{units_per_m: {}}}\n", sequence.depth_units_per_m);
  if (sequence.imu) yaml += fmt::format("imu: {{{}}}\n", imu_yaml(*sequence.imu));
  if (sequence.lidar) yaml += fmt::format("lidar: {{{}}}\n", lidar_yaml(*sequence.lidar));

  std::string rgb = "# timestamp filename\n", depth = rgb, lidar = rgb,
              masks = "# timestamp filename arrival\n";
  bool has_depth = false, has_masks = false;
  for (const auto& frame : sequence.frames) {
    const std::string stamp = format_stamp(frame.stamp_ns);
    rgb += fmt::format("{} {}\n", stamp, frame.rgb.string());
    if (!frame.depth.empty()) depth += fmt::format("{} {}\n", stamp, frame.depth.string()), has_depth = true;
    if (!frame.masks.empty())
      masks += fmt::format("{} {} {}\n", stamp, frame.masks.string(), format_stamp(frame.masks_arrival_ns)),
          has_masks = true;
  }
  for (const auto& scan : sequence.scans)
    lidar += fmt::format("{} {}\n", format_stamp(scan.stamp_ns), scan.file.string());
  write_text(folder / "rgb.txt", rgb);
  if (sequence.lidar) write_text(folder / "lidar.txt", lidar);
  if (has_depth) write_text(folder / "depth.txt", depth);
  if (has_masks) write_text(folder / "masks.txt", masks);
  if (sequence.given_camera) write_tum(folder / "camera_given.tum", *sequence.given_camera);
  write_text(folder / "sequence.yaml", yaml);  // last: a folder without it is no sequence
}

void require_image(const fs::path& path, const cv::Mat& image, const Camera& camera, ImageKind kind) {
  const bool is_color = kind == ImageKind::color;
  if (image.type() != (is_color ? CV_8UC3 : CV_16UC1))
    throw InputError(path, is_color ? "expected an 8-bit colour image" : "expected a 16-bit grey image");
  if (image.cols != camera.width || image.rows != camera.height)
    throw InputError(path, fmt::format("is {}x{}, the camera says {}x{}", image.cols, image.rows,
                                       camera.width, camera.height));
  if (kind != ImageKind::masks) return;
  if (const int ids = count_different(image); ids > kMostIds)
    throw InputError(path, fmt::format("holds {} ids, more than the {} that masks may have", ids, kMostIds));
}

cv::Mat read_rgb(const Sequence& sequence, const SequenceFrame& frame) {
  return read_of_kind(sequence, frame.rgb, ImageKind::color);
}

namespace {

// A depth that would lie behind infinity is none.
void unbias(std::span<float> depths_m, double bias_per_m) {
  for (float& z : depths_m) {
    const float share = 1 - static_cast<float>(bias_per_m) * z;
    z = share > 0 ? z / share : 0;
  }
}

}  // namespace

cv::Mat read_depth(const Sequence& sequence, const SequenceFrame& frame) {
  const cv::Mat units = read_of_kind(sequence, frame.depth, ImageKind::depth);
  cv::Mat depth;
  units.convertTo(depth, CV_32F, 1 / sequence.depth_units_per_m);
  depth.setTo(0, units == kDepthCutOff);
  if (const double bias = sequence.inverse_depth_bias_per_m; bias != 0)
    for (int v = 0; v < depth.rows; ++v)
      unbias({depth.ptr<float>(v), static_cast<std::size_t>(depth.cols)}, bias);
  drop_smeared_edges(depth, sequence.depth_edge_width_px);
  return depth;
}

cv::Mat read_masks(const Sequence& sequence, const SequenceFrame& frame) {
  return read_of_kind(sequence, frame.masks, ImageKind::masks);
}

}  // namespace uniquadric
