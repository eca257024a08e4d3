#include "estimator/segmentation/prompts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Fields = std::vector<std::string_view>;

constexpr std::int64_t kMaxStampOffsetNs = 10'000'000;  // under half the period of a 30 Hz camera

// The frame that a stamp in seconds belongs to; nothing for other texts and for stamps of no frame.
std::optional<std::size_t> frame_of_stamp(const Sequence& sequence, std::string_view text) {
  std::int64_t stamp_ns = 0;
  try {
    stamp_ns = parse_stamp_ns(text);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
  if (sequence.frames.empty()) return std::nullopt;  // of a LiDAR alone
  const auto distance = [&](const SequenceFrame& frame) { return std::abs(frame.stamp_ns - stamp_ns); };
  const auto nearest =
      std::min_element(sequence.frames.begin(), sequence.frames.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  if (distance(*nearest) > kMaxStampOffsetNs) return std::nullopt;
  return nearest - sequence.frames.begin();
}

// The frame of a line's stamp, or an error that names the line.
std::size_t frame_of_line(const Sequence& sequence, const fs::path& file, int line, std::string_view stamp) {
  const auto frame = frame_of_stamp(sequence, stamp);
  if (!frame) throw InputError(file, line, fmt::format("{} is the stamp of no frame", stamp));
  return *frame;
}

// For one object more in a frame: masks name so many.
template <typename Prompt>
void expect_room(const fs::path& file, int line, const std::vector<Prompt>& objects) {
  if (objects.size() >= kMostIds)
    throw InputError(file, line, fmt::format("more than {} objects in one frame", kMostIds));
}

BoxPrompt parse_box(const Sequence& sequence, const fs::path& file, int line, const Fields& fields,
                    std::size_t first) {
  double v[4];
  for (std::size_t i = 0; i < 4; ++i) {
    const auto number = parse_double(fields[first + i]);
    if (!number) throw InputError(file, line, fmt::format("'{}' is not a finite number", fields[first + i]));
    v[i] = *number;
  }
  if (!(v[2] > 0 && v[3] > 0))
    throw InputError(file, line, "a box needs a width and a height greater than 0");
  const Camera& camera = sequence.camera;
  if (v[0] >= camera.width || v[1] >= camera.height || v[0] + v[2] <= 0 || v[1] + v[3] <= 0)
    throw InputError(file, line,
                     fmt::format("the box lies outside the {}x{} image", camera.width, camera.height));
  return {0, v[0], v[1], v[2], v[3]};
}

std::vector<std::vector<BoxPrompt>> read_folder(const fs::path& folder, const Sequence& sequence) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".txt") files.push_back(entry.path());
  if (files.empty()) throw InputError(folder, "holds no prompts (STAMP.txt)");
  std::sort(files.begin(), files.end());
  std::vector<std::vector<BoxPrompt>> frames(sequence.frames.size());
  for (const fs::path& file : files) {
    const auto frame = frame_of_stamp(sequence, file.stem().string());
    if (!frame) throw InputError(file, "its name is the stamp of no frame");
    for_each_line(file, [&](int line, const Fields& fields) {
      expect_room(file, line, frames[*frame]);
      if (fields.size() != 4 && fields.size() != 5) throw InputError(file, line, "expected: x y w h [score]");
      if (fields.size() == 5 && !parse_double(fields[4]))
        throw InputError(file, line, fmt::format("'{}' is not a finite number", fields[4]));
      frames[*frame].push_back(parse_box(sequence, file, line, fields, 0));
    });
  }
  associate_boxes(frames, sequence.camera.width);
  return frames;
}

int parse_id(const fs::path& file, int line, std::string_view text) {
  const auto id = parse_integer(text);
  if (!id || *id <= 0 || *id > std::numeric_limits<std::uint16_t>::max())  // ids become 16-bit masks
    throw InputError(file, line, fmt::format("id '{}' is not an integer from 1 to 65535", text));
  return static_cast<int>(*id);
}

std::vector<std::vector<BoxPrompt>> read_file(const fs::path& file, const Sequence& sequence) {
  std::vector<std::vector<BoxPrompt>> frames(sequence.frames.size());
  std::size_t columns = 0;
  for_each_line(file, [&](int line, const Fields& fields) {
    if (columns == 0) columns = fields.size();
    if (fields.size() != columns || (columns != 5 && columns != 6))
      throw InputError(file, line,
                       "expected in every line: stamp x y w h, or in every line: stamp x y w h id");
    auto& boxes = frames[frame_of_line(sequence, file, line, fields[0])];
    expect_room(file, line, boxes);
    BoxPrompt box = parse_box(sequence, file, line, fields, 1);
    if (columns == 6) box.id = parse_id(file, line, fields[5]);
    const auto is_same = [&](const BoxPrompt& other) { return columns == 6 && other.id == box.id; };
    if (std::any_of(boxes.begin(), boxes.end(), is_same))
      throw InputError(file, line, fmt::format("a second box of object {} in one frame", box.id));
    boxes.push_back(box);
  });
  if (columns == 0) throw InputError(file, "holds no prompts");
  if (columns == 5) associate_boxes(frames, sequence.camera.width);
  return frames;
}

double centre_distance(const BoxPrompt& a, const BoxPrompt& b) {
  return std::hypot(a.x + a.width / 2 - b.x - b.width / 2, a.y + a.height / 2 - b.y - b.height / 2);
}

// Greedily pairs the boxes that have no id yet with the tracks not yet used, best score first, scores above 0
// only.
template <typename Score>
void pair_greedily(std::vector<BoxPrompt>& boxes, const std::vector<BoxPrompt>& tracks, std::set<int>& used,
                   const Score& score) {
  while (true) {
    double best = 0;
    BoxPrompt* winner = nullptr;
    int id = 0;
    for (auto& box : boxes)
      for (const auto& track : tracks)
        if (box.id == 0 && !used.contains(track.id) && score(box, track) > best)
          best = score(box, track), winner = &box, id = track.id;
    if (!winner) return;
    winner->id = id;
    used.insert(id);
  }
}

PointPrompt parse_point(const Sequence& sequence, const fs::path& file, int line, const Fields& fields) {
  PointPrompt point;
  for (const auto& [text, value] : {std::pair(fields[1], &point.u), {fields[2], &point.v}}) {
    const auto number = parse_double(text);
    if (!number) throw InputError(file, line, fmt::format("'{}' is not a finite number", text));
    *value = *number;
  }
  if (!sequence.camera.contains({point.u, point.v}))
    throw InputError(
        file, line,
        fmt::format("the point lies outside the {}x{} image", sequence.camera.width, sequence.camera.height));
  // the outer half of a border pixel is the image too, but no pixel's centre
  point.u = std::clamp(point.u, 0.0, sequence.camera.width - 1.0);
  point.v = std::clamp(point.v, 0.0, sequence.camera.height - 1.0);
  if (fields.size() == 4) point.id = parse_id(file, line, fields[3]);
  return point;
}

}  // namespace

Prompts::Prompts(const fs::path& boxes)
    : kind(boxes.empty() ? PromptKind::everything : PromptKind::boxes), path(boxes) {}

Prompts parse_prompts(const std::string& text) {
  for (const auto& [prefix, kind] : {std::pair("points:", PromptKind::points), {"boxes:", PromptKind::boxes}})
    if (text.starts_with(prefix)) return {kind, text.substr(std::string_view(prefix).size())};
  if (text.empty() || text == "everything") return {};
  return {PromptKind::boxes, text};
}

std::vector<std::vector<PointPrompt>> read_point_prompts(const fs::path& path, const Sequence& sequence) {
  if (!fs::is_regular_file(path)) throw InputError(path, "no such file of point prompts");
  std::vector<std::vector<PointPrompt>> frames(sequence.frames.size());
  std::size_t columns = 0;
  for_each_line(path, [&](int line, const Fields& fields) {
    if (columns == 0) columns = fields.size();
    if (fields.size() != columns || (columns != 3 && columns != 4))
      throw InputError(path, line, "expected in every line: stamp u v, or in every line: stamp u v id");
    auto& points = frames[frame_of_line(sequence, path, line, fields[0])];
    if (columns == 3) expect_room(path, line, points);
    points.push_back(parse_point(sequence, path, line, fields));
    if (columns == 3) points.back().id = static_cast<int>(points.size());
  });
  if (columns == 0) throw InputError(path, "holds no prompts");
  return frames;
}

bool have_ids(const Prompts& prompts) {
  if (prompts.kind != PromptKind::points) return prompts.kind == PromptKind::boxes;
  bool found = false;
  for_each_line(prompts.path, [&](int, const Fields& fields) { found = found || fields.size() == 4; });
  return found;
}

double box_iou(const BoxPrompt& a, const BoxPrompt& b) {
  const double width = std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x);
  const double height = std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y);
  const double both = std::max(width, 0.0) * std::max(height, 0.0);
  return both / (a.width * a.height + b.width * b.height - both);
}

void associate_boxes(std::vector<std::vector<BoxPrompt>>& frames, double image_width_px) {
  std::vector<BoxPrompt> tracks;  // the last box of each
  for (auto& boxes : frames) {
    std::set<int> used;
    pair_greedily(boxes, tracks, used, box_iou);
    pair_greedily(boxes, tracks, used, [&](const BoxPrompt& a, const BoxPrompt& b) {
      return image_width_px / 2 - centre_distance(a, b);
    });
    for (auto& box : boxes) {
      if (box.id == 0) {
        box.id = static_cast<int>(tracks.size()) + 1;
        tracks.push_back(box);
      }
      tracks[box.id - 1] = box;
    }
  }
}

std::vector<std::vector<BoxPrompt>> read_box_prompts(const fs::path& path, const Sequence& sequence) {
  if (!fs::exists(path)) throw InputError(path, "no such file or folder of prompts");
  return fs::is_directory(path) ? read_folder(path, sequence) : read_file(path, sequence);
}

}  // namespace uniquadric
