#include "estimator/perception/perception.h"

#include <fmt/format.h>
#include <algorithm>

#include <cstring>
#include <span>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/sequence/calibration.h"
#include "core/sequence/trajectory.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kSchema = 1;
constexpr char kMagic[8] = {'U', 'Q', 'P', 'E', 'R', 'C', '0', '2'};
constexpr std::uint64_t kMaxCount = 1u << 28;  // of anything in a list; more is a damaged file

// Appends values as they lie in memory (little-endian machines alone are supported).
class Writer {
 public:
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void numbers(std::span<const double> values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  Reader(const fs::path& path, std::string_view bytes) : path_(path), left_(bytes) {}
  template <typename T>
  T get() {
    T value;
    take(&value, sizeof value);
    return value;
  }
  void numbers(std::span<double> values) { take(values.data(), values.size_bytes()); }
  // A number of items of at least `size` bytes each, which the rest of the file must hold.
  std::uint64_t count(std::uint64_t size) {
    const auto n = get<std::uint64_t>();
    if (n > kMaxCount || n * size > left_.size()) fail();
    return n;
  }
  bool at_end() const { return left_.empty(); }
  [[noreturn]] void fail() const { throw InputError(path_, "is damaged or truncated"); }

 private:
  void take(void* to, std::size_t size) {
    if (left_.size() < size) fail();
    std::memcpy(to, left_.data(), size);
    left_.remove_prefix(size);
  }
  const fs::path& path_;
  std::string_view left_;
};

void put(Writer& out, const Pose& pose) {
  out.numbers({pose.rotation.coeffs().data(), 4});
  out.numbers({pose.translation.data(), 3});
}

Pose get_pose(Reader& in) {
  Pose pose;
  in.numbers({pose.rotation.coeffs().data(), 4});
  in.numbers({pose.translation.data(), 3});
  return pose;
}

void put(Writer& out, const SupportLine& line) {
  out.numbers({line.normal.data(), 2});
  out.put(line.offset_px);
  out.put(line.free);
}

SupportLine get_line(Reader& in) {
  SupportLine line;
  in.numbers({line.normal.data(), 2});
  line.offset_px = in.get<double>();
  line.free = in.get<char>() != 0;
  return line;
}

void put(Writer& out, const Silhouette& s) {
  out.numbers({s.rot_bbox.center.data(), 2});
  for (const double value : {s.rot_bbox.semi_major, s.rot_bbox.semi_minor, s.rot_bbox.angle_rad, s.area_px})
    out.put(value);
  for (const bool free : s.side_free) out.put(free);
  out.put(static_cast<std::uint64_t>(s.support.size()));
  for (const SupportLine& line : s.support) put(out, line);
  for (const SupportLine& line : s.bbox) put(out, line);
  out.put(s.segmented);
  out.put(s.known_at_frame);
}

Silhouette get_silhouette(Reader& in) {
  Silhouette s;
  in.numbers({s.rot_bbox.center.data(), 2});
  for (double* value : {&s.rot_bbox.semi_major, &s.rot_bbox.semi_minor, &s.rot_bbox.angle_rad, &s.area_px})
    *value = in.get<double>();
  for (bool& free : s.side_free) free = in.get<char>() != 0;
  s.support.resize(in.count(25));
  for (SupportLine& line : s.support) line = get_line(in);
  for (SupportLine& line : s.bbox) line = get_line(in);
  s.segmented = in.get<char>() != 0;
  s.known_at_frame = in.get<std::int64_t>();
  return s;
}

void put(Writer& out, const BodyObservation& body) {
  out.put(static_cast<std::int64_t>(body.id));
  for (const auto& silhouette : {body.silhouette, body.segmented}) {
    out.put(silhouette.has_value());
    if (silhouette) put(out, *silhouette);
  }
  out.put(body.motion.has_value());
  if (body.motion) put(out, *body.motion);
  out.put(static_cast<std::uint64_t>(body.features.size()));
  for (const Feature& feature : body.features) {
    out.put(feature.track);
    out.numbers({feature.pixel.data(), 2});
    out.put(feature.depth_m);
    out.put(feature.depth_sigma_m);
  }
  for (const Eigen::Matrix3Xd* vectors : {&body.points, &body.normals}) {
    out.put(static_cast<std::uint64_t>(vectors->cols()));
    out.numbers({vectors->data(), static_cast<std::size_t>(vectors->size())});
  }
}

BodyObservation get_body(Reader& in) {
  BodyObservation body;
  body.id = static_cast<int>(in.get<std::int64_t>());
  for (auto* silhouette : {&body.silhouette, &body.segmented})
    if (in.get<char>() != 0) *silhouette = get_silhouette(in);
  if (in.get<char>() != 0) body.motion = get_pose(in);
  body.features.resize(in.count(40));
  for (Feature& feature : body.features) {
    feature.track = in.get<std::int64_t>();
    in.numbers({feature.pixel.data(), 2});
    feature.depth_m = in.get<double>();
    feature.depth_sigma_m = in.get<double>();
  }
  for (Eigen::Matrix3Xd* vectors : {&body.points, &body.normals}) {
    vectors->resize(3, static_cast<Eigen::Index>(in.count(24)));
    in.numbers({vectors->data(), static_cast<std::size_t>(vectors->size())});
  }
  return body;
}

}  // namespace

bool is_whole(const Silhouette& silhouette) {
  return std::all_of(silhouette.support.begin(), silhouette.support.end(),
                     [](const SupportLine& line) { return line.free; });
}

void write_perception(const fs::path& folder, const Perception& perception) {
  Trajectory camera;
  Writer out;
  for (const char c : kMagic) out.put(c);
  out.put(static_cast<std::uint64_t>(perception.frames.size()));
  for (const PerceivedFrame& frame : perception.frames) {
    if (frame.world_from_camera) camera.push_back({frame.stamp_ns, *frame.world_from_camera});
    out.put(frame.frame);
    out.put(frame.stamp_ns);
    out.put(frame.world_from_camera.has_value());
    if (frame.world_from_camera) put(out, *frame.world_from_camera);
    out.put(frame.has_masks);
    out.put(static_cast<std::uint64_t>(frame.bodies.size()));
    for (const BodyObservation& body : frame.bodies) put(out, body);
  }
  write_tum(folder / "camera.tum", camera);
  write_camera_yaml(folder / "camera.yaml", perception.camera);
  write_text(folder / "observations.bin", out.bytes());
  write_text(folder / "perception.yaml",
             fmt::format("schema: {}\nprogram: {}\nkey: {}\nframes: {}\n", kSchema, yaml_quoted(kProgram),
                         yaml_quoted(perception.key), perception.frames.size()));
}

std::string perception_key_of(const fs::path& folder) {
  const ConfigNode root = ConfigNode::load(folder / "perception.yaml");
  if (root.get<int>("schema") != kSchema) root.at("schema").fail(fmt::format("expected {}", kSchema));
  return root.get<std::string>("key");
}

Perception read_perception(const fs::path& folder) {
  Perception perception;
  perception.key = perception_key_of(folder);
  perception.camera = read_camera_yaml(folder / "camera.yaml");
  const fs::path path = folder / "observations.bin";
  const std::string bytes = read_text(path);
  Reader in(path, bytes);
  for (const char c : kMagic)
    if (in.get<char>() != c) throw InputError(path, "holds no observations of this version");
  perception.frames.resize(in.count(26));
  for (PerceivedFrame& frame : perception.frames) {
    frame.frame = in.get<std::int64_t>();
    frame.stamp_ns = in.get<std::int64_t>();
    if (in.get<char>() != 0) frame.world_from_camera = get_pose(in);
    frame.has_masks = in.get<char>() != 0;
    frame.bodies.resize(in.count(27));
    for (BodyObservation& body : frame.bodies) body = get_body(in);
  }
  if (!in.at_end()) in.fail();
  return perception;
}

}  // namespace uniquadric
