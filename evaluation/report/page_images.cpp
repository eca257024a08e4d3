#include <algorithm>
#include <cassert>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/base/text.h"
#include "core/sequence/image_file.h"
#include "evaluation/report/page.h"
#include "evaluation/report/scenery_parts.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

struct Picture {
  long long frame = 0;
  std::string jpeg;
};
struct Gallery {
  const Cell* cell;
  std::vector<Picture> pictures;
};

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < n ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

// A cut image shows in no browser. Throws InputError.
std::string read_jpeg(const fs::path& file) {
  std::string bytes = read_file(file, kImageFile);
  if (!is_whole_jpeg(bytes)) throw InputError(file, "is no whole JPEG image");
  return bytes;
}

std::vector<Picture> read_pictures(const fs::path& folder) {
  std::vector<Picture> pictures;
  if (!fs::is_directory(folder)) return pictures;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto frame = parse_integer(entry.path().stem().string());
    if (frame && entry.path().extension() == ".jpg") pictures.push_back({*frame, read_jpeg(entry.path())});
  }
  std::sort(pictures.begin(), pictures.end(), [](const auto& a, const auto& b) { return a.frame < b.frame; });
  return pictures;
}

// Of one picture the middle one: in the first no estimate has begun.
std::vector<std::size_t> kept(const Gallery& gallery, std::size_t count) {
  const std::size_t total = gallery.pictures.size();
  if (count == 1 && total > 0) return {total / 2};
  return evenly_spaced(total, std::min(count, total));
}

std::size_t size_of(const Gallery& gallery, std::size_t count) {
  std::size_t bytes = 0;
  for (const std::size_t i : kept(gallery, count)) bytes += gallery.pictures[i].jpeg.size();
  return bytes;
}

std::size_t size_of(const std::vector<Gallery>& galleries, std::size_t count) {
  std::size_t bytes = 0;
  for (const Gallery& gallery : galleries) bytes += size_of(gallery, count);
  return bytes;
}

std::vector<Gallery> read_galleries(const Results& results) {
  std::vector<Gallery> galleries;
  std::set<std::pair<std::string, std::string>> seen;
  for (const Cell& cell : results.cells) {
    if (cell.status != CellStatus::ok || !cell.output.empty() || seen.contains({cell.scene, cell.variant}))
      continue;
    Gallery gallery{&cell, read_pictures(results.folder / cell.folder / "overlays")};
    if (gallery.pictures.empty()) continue;
    seen.emplace(cell.scene, cell.variant);
    galleries.push_back(std::move(gallery));
  }
  return galleries;
}

// Frames that are kept of each of these, so that all fit.
std::size_t count_that_fits(const std::vector<Gallery>& galleries, std::size_t most_bytes) {
  std::size_t count = 0;
  for (const Gallery& gallery : galleries) count = std::max(count, gallery.pictures.size());
  while (count > 0 && size_of(galleries, count) > most_bytes) --count;
  return count;
}

// Those that keep a frame where not all can: as many as fit, evenly spaced.
std::vector<std::size_t> galleries_that_fit(const std::vector<Gallery>& galleries, std::size_t most_bytes) {
  for (std::size_t n = galleries.size(); n > 0; --n) {
    const std::vector<std::size_t> chosen = evenly_spaced(galleries.size(), n);
    std::size_t bytes = 0;
    for (const std::size_t i : chosen) bytes += size_of(galleries[i], 1);
    if (bytes <= most_bytes) return chosen;
  }
  return {};
}

// How many frames each of them keeps.
std::vector<std::size_t> kept_counts(const std::vector<Gallery>& galleries, std::size_t most_bytes) {
  const std::size_t count = count_that_fits(galleries, most_bytes);
  std::vector<std::size_t> counts(galleries.size(), count);
  if (count == 0)
    for (const std::size_t i : galleries_that_fit(galleries, most_bytes)) counts[i] = 1;
  return counts;
}

constexpr std::size_t kMostScenery = 40;  // ours: more would leave no frame to each
constexpr std::size_t kMostClouds = 4;    // ours: a cloud is 150 kB

// The frames that scenery.json lists and that are kept, with their pictures.
json kept_frames(const json& listed, const Gallery& film, std::size_t count) {
  json frames = json::array();
  for (const std::size_t i : evenly_spaced(film.pictures.size(), std::min(count, film.pictures.size())))
    for (const json& frame : listed)
      if (frame["frame"] == film.pictures[i].frame)
        frames.push_back({{"frame", film.pictures[i].frame},
                          {"stamp_ns", frame["stamp_ns"]},
                          {"jpeg", base64(film.pictures[i].jpeg)}});
  return frames;
}

}  // namespace

std::vector<std::size_t> evenly_spaced(std::size_t total, std::size_t count) {
  assert(count <= total);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < count; ++i)
    indices.push_back(count == 1 ? 0 : (i * (total - 1) + (count - 1) / 2) / (count - 1));
  return indices;
}

std::string page_images(const Results& results, const PageOptions& options) {
  const std::vector<Gallery> galleries = read_galleries(results);
  const std::vector<std::size_t> counts = kept_counts(galleries, options.image_bytes);
  json list = json::array();
  for (std::size_t g = 0; g < galleries.size(); ++g) {
    const Gallery& gallery = galleries[g];
    json frames = json::array();
    for (const std::size_t i : kept(gallery, counts[g]))
      frames.push_back({{"frame", gallery.pictures[i].frame}, {"jpeg", base64(gallery.pictures[i].jpeg)}});
    list.push_back({{"scene", gallery.cell->scene},
                    {"variant", gallery.cell->variant},
                    {"seed", gallery.cell->seed},
                    {"available", gallery.pictures.size()},
                    {"frames", frames}});
  }
  return list.dump();
}

std::string page_scenery(const Results& results, const PageOptions& options) {
  json sceneries = json::object();
  std::vector<Gallery> films;
  std::vector<std::string> names;
  std::size_t mesh_bytes = 0;
  for (const std::string& scene : scenes_of(results)) {
    const fs::path folder = results.folder / "scenery" / scene;
    if (names.size() == kMostScenery || !fs::exists(folder / "scenery.json")) continue;
    json& scenery = sceneries[scene] = read_scenery(folder / "scenery.json");
    if (names.size() >= kMostClouds) scenery["cloud"] = nullptr;
    if (mesh_bytes > options.mesh_bytes) scenery["meshes"] = json::array();
    mesh_bytes += scenery["meshes"].dump().size();
    films.push_back({nullptr, read_pictures(folder / "frames")});
    names.push_back(scene);
  }
  const std::size_t count = count_that_fits(films, options.film_bytes);
  for (std::size_t i = 0; i < names.size(); ++i) {
    json& frames = sceneries[names[i]]["frames"];
    frames = kept_frames(frames, films[i], count);
  }
  return sceneries.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace uniquadric
