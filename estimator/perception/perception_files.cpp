#include "estimator/perception/perception_files.h"

#include <fmt/format.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <span>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/read_file.h"
#include "core/base/resource_usage.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/sequence/calibration.h"
#include "core/sequence/ply.h"
#include "core/sequence/trajectory.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kSchema = 3;
constexpr const char *kBias = "inverse_depth_bias_per_m", *kBiasSigma = "inverse_depth_bias_sigma_per_m",
                     *kEdgeWidth = "depth_edge_width_px";
// The magic, the bodies of each frame, the index of the frames, and where that is.
constexpr const char* kObservations = "observations.bin";
constexpr const char* kMasks = "masks";
constexpr char kMagic[8] = {'U', 'Q', 'P', 'E', 'R', 'C', '0', '7'};
constexpr std::uint64_t kMaxCount = 1u << 28;  // of anything in a list; more is a damaged file

[[noreturn]] void throw_damaged(const fs::path& path) {
  throw InputError(path, "is damaged or truncated");
}

// Appends values as they lie in memory (little-endian machines alone are supported).
class Writer {
 public:
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <typename T>
  void numbers(std::span<const T> values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  void numbers(std::span<const double> values) { numbers<double>(values); }
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
  template <typename T>
  void numbers(std::span<T> values) {
    take(values.data(), values.size_bytes());
  }
  void numbers(std::span<double> values) { numbers<double>(values); }
  // A number of items of at least `size` bytes each, which the rest of the file must hold.
  std::uint64_t count(std::uint64_t size) {
    const auto n = get<std::uint64_t>();
    if (n > kMaxCount || n * size > left_.size()) fail();
    return n;
  }
  bool at_end() const { return left_.empty(); }
  [[noreturn]] void fail() const { throw_damaged(path_); }

 private:
  void take(void* to, std::size_t size) {
    if (left_.size() < size) fail();
    if (size == 0) return;  // nowhere to copy to
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

template <typename Columns>
void put_columns(Writer& out, const Columns& columns) {
  out.put(static_cast<std::uint64_t>(columns.cols()));
  out.numbers(std::span(columns.data(), static_cast<std::size_t>(columns.size())));
}

template <typename Columns>
void get_columns(Reader& in, Columns& columns) {
  columns.resize(3, static_cast<Eigen::Index>(in.count(3 * sizeof(typename Columns::Scalar))));
  in.numbers(std::span(columns.data(), static_cast<std::size_t>(columns.size())));
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
  out.put(body.contact.has_value());
  if (body.contact) {
    out.numbers({body.contact->normal.data(), 3});
    out.put(body.contact->offset_m);
    out.put(body.contact->noise_m);
  }
  out.put(body.motion.has_value());
  if (body.motion) put(out, *body.motion);
  out.put(static_cast<std::uint64_t>(body.features.size()));
  for (const Feature& feature : body.features) {
    out.put(feature.track);
    out.numbers({feature.pixel.data(), 2});
    out.put(feature.depth_m);
    out.put(feature.depth_sigma_m);
    out.put(feature.rim);
  }
  put_columns(out, body.points);
  put_columns(out, body.normals);
  put_columns(out, body.colors);
  out.put(body.row_gap_m);
  out.put(body.beam_gap_m);
  out.put(body.known_at_frame);
  out.put(static_cast<std::uint64_t>(body.cut.size()));
  for (const bool cut : body.cut) out.put(cut);
}

BodyObservation get_body(Reader& in) {
  BodyObservation body;
  body.id = static_cast<int>(in.get<std::int64_t>());
  for (auto* silhouette : {&body.silhouette, &body.segmented})
    if (in.get<char>() != 0) *silhouette = get_silhouette(in);
  if (in.get<char>() != 0) {
    ContactPlane& contact = body.contact.emplace();
    in.numbers({contact.normal.data(), 3});
    contact.offset_m = in.get<double>();
    contact.noise_m = in.get<double>();
  }
  if (in.get<char>() != 0) body.motion = get_pose(in);
  body.features.resize(in.count(41));
  for (Feature& feature : body.features) {
    feature.track = in.get<std::int64_t>();
    in.numbers({feature.pixel.data(), 2});
    feature.depth_m = in.get<double>();
    feature.depth_sigma_m = in.get<double>();
    feature.rim = in.get<char>() != 0;
  }
  get_columns(in, body.points);
  get_columns(in, body.normals);
  get_columns(in, body.colors);
  body.row_gap_m = in.get<double>();
  body.beam_gap_m = in.get<double>();
  body.known_at_frame = in.get<std::int64_t>();
  body.cut.resize(in.count(1));
  for (std::size_t i = 0; i < body.cut.size(); ++i) body.cut[i] = in.get<char>() != 0;
  return body;
}

FilePlace place_of(std::uint64_t offset, const std::string& bytes) {
  return {offset, bytes.size(), Hash().add(bytes).value()};
}

// Files of sizes that contradict what they say are damaged.
std::string read_part(const fs::path& path, std::uint64_t offset, std::uint64_t size) {
  require_regular_file(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path, fmt::format("cannot be read: {}", std::strerror(errno)));
  const std::uint64_t whole = fs::file_size(path);
  if (offset > whole || size > whole - offset) throw_damaged(path);
  std::string bytes(size, '\0');
  file.seekg(static_cast<std::streamoff>(offset));
  if (!file.read(bytes.data(), std::ssize(bytes))) throw_damaged(path);
  return bytes;
}

std::string read_place(const fs::path& path, const FilePlace& place) {
  std::string bytes = read_part(path, place.offset, place.size);
  if (Hash().add(bytes).value() != place.hash) throw_damaged(path);
  return bytes;
}

// FRAME.png, of six digits at least.
bool is_mask_name(const std::string& name) {
  const std::size_t digits = name.find_first_not_of("0123456789");
  return digits != std::string::npos && digits >= 6 && name.substr(digits) == ".png";
}

ConfigNode load_description(const fs::path& folder) {
  ConfigNode root = ConfigNode::load(folder / "perception.yaml");
  if (root.get<int>("schema") != kSchema) root.at("schema").fail(fmt::format("expected {}", kSchema));
  return root;
}

PerceptionSource source_in(const ConfigNode& description) {
  return {description.get<std::string>("key"), description.get<std::string>("sequence", ""),
          description.get<std::string>("sequence_hash", "")};
}

}  // namespace

PerceptionWriter::PerceptionWriter(fs::path folder, const Camera& camera, PerceptionSource source)
    : folder_(std::move(folder)),
      camera_(camera),
      source_(std::move(source)),
      file_(folder_ / kObservations, std::ios::binary) {
  write(std::string(kMagic, sizeof kMagic));
}

void PerceptionWriter::write(const std::string& bytes) {
  if (!file_.write(bytes.data(), std::ssize(bytes)).flush()) throw_unwritable(folder_ / kObservations);
  size_ += bytes.size();
}

void PerceptionWriter::add(const PerceivedFrame& frame) {
  Writer bodies;
  bodies.put(static_cast<std::uint64_t>(frame.bodies.size()));
  for (const BodyObservation& body : frame.bodies) put(bodies, body);
  frames_.push_back(frame);
  places_.push_back(place_of(size_, bodies.bytes()));
  write(bodies.bytes());
}

void PerceptionWriter::keep_map(const std::vector<Eigen::Vector3d>& points) const {
  SurfaceFile map;
  for (const Eigen::Vector3d& p : points) map.points.push_back(p.cast<float>());
  if (!map.points.empty())
    write_surface_ply(folder_ / kMapFile, map, "map of the surroundings, world, metres");
}

void PerceptionWriter::finish(const CameraTrajectories& camera, int ego_restarts,
                              const std::optional<DepthBias>& depth_bias, double depth_edge_width_px) {
  const auto causal = by_stamp(camera.causal), fixed_lag = by_stamp(camera.fixed_lag),
             final = by_stamp(camera.final);
  Writer index, end;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const bool is_lost = !final.contains(frames_[i].stamp_ns);
    index.put(frames_[i].frame);
    index.put(frames_[i].stamp_ns);
    index.put(frames_[i].has_masks);
    index.put(static_cast<char>(frames_[i].depth_refused | frames_[i].depth_changed << 1));
    for (const auto* poses : {&causal, &fixed_lag, &final}) {
      const auto pose = poses->find(frames_[i].stamp_ns);
      const bool is_known = !is_lost && pose != poses->end();
      index.put(is_known);
      if (is_known) put(index, pose->second);
    }
    index.put(places_[i]);
  }
  end.put(place_of(size_, index.bytes()));
  write(index.bytes());
  write(end.bytes());
  write_tum(folder_ / "camera.tum", camera.final);
  write_camera_yaml(folder_ / "camera.yaml", camera_);
  write_text(folder_ / "perception.yaml",
             fmt::format("schema: {}\nprogram: {}\nkey: {}\nsequence: {}\nsequence_hash: {}\nframes: {}\n"
                         "ego_restarts: {}\n{}camera_hash: \"{}\"\n",
                         kSchema, yaml_quoted(kProgram), yaml_quoted(source_.key),
                         yaml_quoted(source_.sequence), yaml_quoted(source_.sequence_hash), frames_.size(),
                         ego_restarts, depth_faults_yaml(depth_bias, depth_edge_width_px),
                         hex(hash_file(folder_ / "camera.yaml"))));
}

std::string depth_faults_yaml(const std::optional<DepthBias>& bias, double edge_width_px) {
  std::string text;
  if (bias) text += fmt::format("{}: {}\n{}: {}\n", kBias, bias->per_m, kBiasSigma, bias->sigma_per_m);
  if (edge_width_px > 1) text += fmt::format("{}: {}\n", kEdgeWidth, edge_width_px);
  return text;
}

std::vector<fs::path> foreign_files(const fs::path& folder) {
  const std::set<std::string> own = {"perception.yaml", "camera.yaml", "camera.tum", kObservations,
                                     "timing.csv",      kUsageFile,    kMapFile,     kKindFile};
  std::vector<fs::path> foreign;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path name = entry.path().filename();
    if (name != kMasks || !entry.is_directory()) {
      if (!own.contains(name.string())) foreign.push_back(name);
      continue;
    }
    for (const auto& mask : fs::directory_iterator(entry.path()))
      if (!is_mask_name(mask.path().filename().string())) foreign.push_back(name / mask.path().filename());
  }
  std::sort(foreign.begin(), foreign.end());
  return foreign;
}

PerceptionSource perception_source_of(const fs::path& folder) {
  return source_in(load_description(folder));
}

Perception::Perception(const fs::path& folder)
    : file_(folder / kObservations), camera_(read_camera_yaml(folder / "camera.yaml")) {
  const ConfigNode root = load_description(folder);
  source_ = source_in(root);
  ego_restarts_ = root.get<int>("ego_restarts", 0);
  if (root.has(kBias)) depth_bias_ = DepthBias{root.get<double>(kBias), root.get<double>(kBiasSigma)};
  depth_edge_width_px_ = root.get<double>(kEdgeWidth, 1);
  if (read_part(file_, 0, sizeof kMagic) != std::string_view(kMagic, sizeof kMagic))
    throw InputError(file_, "holds no observations of this version");
  const std::string end = read_part(file_, fs::file_size(file_) - sizeof(FilePlace), sizeof(FilePlace));
  const std::string bytes = read_place(file_, Reader(file_, end).get<FilePlace>());
  for (Reader index(file_, bytes); !index.at_end();) {
    FrameInfo& frame = frames_.emplace_back();
    frame.frame = index.get<std::int64_t>();
    frame.stamp_ns = index.get<std::int64_t>();
    frame.has_masks = index.get<char>() != 0;
    const auto depth = index.get<char>();
    frame.depth_refused = depth & 1;
    frame.depth_changed = depth & 2;
    for (auto* pose : {&frame.world_from_camera, &frame.lagged_camera, &frame.final_camera})
      if (index.get<char>() != 0) *pose = get_pose(index);
    frame.camera_came_late = frame.final_camera && !frame.world_from_camera;
    if (frame.camera_came_late) frame.world_from_camera = frame.final_camera;
    places_.push_back(index.get<FilePlace>());
  }
  if (root.get<std::int64_t>("frames") != std::ssize(frames_))
    root.at("frames").fail(fmt::format("expected {}, as observations.bin has", frames_.size()));
  const std::string hash = hex(hash_file(folder / "camera.yaml"));
  if (const auto made = root.get<std::string>("camera_hash"); made != hash)
    throw InputError(folder / "camera.yaml", fmt::format("has changed: its hash is {}, was {}", hash, made));
}

PerceivedFrame Perception::read(std::size_t index) const {
  const std::string bytes = read_place(file_, places_.at(index));
  Reader in(file_, bytes);
  PerceivedFrame frame{frames_.at(index), {}};
  frame.bodies.resize(in.count(27));
  for (BodyObservation& body : frame.bodies) body = get_body(in);
  if (!in.at_end()) in.fail();
  return frame;
}

}  // namespace uniquadric
