#include "core/base/hash.h"
#include "estimator/perception/perception_files.h"
#include "estimator/segmentation/prompts.h"
#include "fuzz/target.h"

#include <cstring>
#include <fstream>

namespace uniquadric::fuzz {
namespace {
namespace fs = std::filesystem;

void write(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

template <typename T>
void put(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

FilePlace place(std::uint64_t offset, const std::string& bytes) {
  return {offset, bytes.size(), Hash().add(bytes).value()};
}

// A perception of one frame without bodies, its files those of a PerceptionWriter.
void write_perception(const fs::path& folder) {
  PerceptionWriter writer(folder, Camera{4, 4, 4, 4, 2, 2, {}}, {});
  writer.add({});
  writer.finish({});
}

void read_all(const fs::path& folder) {
  const Perception perception(folder);
  for (std::size_t i = 0; i < perception.frames().size(); ++i) perception.read(i);
}

const Target description("perception_yaml", "perception.yaml", [](const fs::path& file) {
  static const bool written = [&] {
    fs::rename(file, file.string() + ".fed");
    write_perception(file.parent_path());
    fs::rename(file.string() + ".fed", file);
    return true;
  }();
  (void)written;
  read_all(file.parent_path());
});

// The bytes are the frame's bodies, or (first bit of the first) the index, hashed as a writer would have
// them.
const Target observations("observations_bin", "fed", [](const fs::path& file) {
  const fs::path folder = file.parent_path();
  if (!fs::exists(folder / "perception.yaml")) write_perception(folder);
  std::string fed(fs::file_size(file), '\0');
  std::ifstream(file, std::ios::binary).read(fed.data(), std::ssize(fed));
  if (fed.empty()) return;
  const bool is_index = fed[0] & 1;
  fed.erase(0, 1);
  std::string bytes = "UQPERC05", index = is_index ? fed : "";
  if (!is_index) {
    put(index, std::array<std::int64_t, 2>{0, 0});
    index += std::string(3, '\0');
    put(index, place(bytes.size(), fed));
    bytes += fed;
  }
  const FilePlace end = place(bytes.size(), index);
  bytes += index;
  put(bytes, end);
  write(folder / "observations.bin", bytes);
  read_all(folder);
});

Sequence small_sequence() {
  Sequence sequence;
  sequence.camera = {640, 480, 500, 500, 320, 240, {}};
  for (int i = 0; i < 3; ++i) {
    sequence.frames.emplace_back();
    sequence.frames.back().stamp_ns = i * 1'000'000'000ll;
  }
  return sequence;
}
const Target boxes("prompt_boxes", "boxes.txt",
                   [](const fs::path& file) { read_box_prompts(file, small_sequence()); });
const Target points("prompt_points", "points.txt",
                    [](const fs::path& file) { read_point_prompts(file, small_sequence()); });
const Target folder_boxes("prompt_folder", "boxes/1.0.txt", [](const fs::path& file) {
  read_box_prompts(file.parent_path(), small_sequence());
});

}  // namespace
}  // namespace uniquadric::fuzz
