#include <algorithm>
#include <cassert>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/read_file.h"
#include "core/base/text.h"
#include "evaluation/report/page.h"

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

std::vector<Picture> read_pictures(const fs::path& folder) {
  std::vector<Picture> pictures;
  if (!fs::is_directory(folder)) return pictures;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto frame = parse_integer(entry.path().stem().string());
    if (frame && entry.path().extension() == ".jpg")
      pictures.push_back({*frame, read_file(entry.path(), kImageFile)});
  }
  std::sort(pictures.begin(), pictures.end(), [](const auto& a, const auto& b) { return a.frame < b.frame; });
  return pictures;
}

std::size_t size_of(const std::vector<Gallery>& galleries, std::size_t count) {
  std::size_t bytes = 0;
  for (const Gallery& gallery : galleries)
    for (const std::size_t i :
         evenly_spaced(gallery.pictures.size(), std::min(count, gallery.pictures.size())))
      bytes += gallery.pictures[i].jpeg.size();
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
  std::size_t count = 0;
  for (const Gallery& gallery : galleries) count = std::max(count, gallery.pictures.size());
  while (count > 0 && size_of(galleries, count) > options.image_bytes) --count;
  json list = json::array();
  for (const Gallery& gallery : galleries) {
    json frames = json::array();
    for (const std::size_t i :
         evenly_spaced(gallery.pictures.size(), std::min(count, gallery.pictures.size())))
      frames.push_back({{"frame", gallery.pictures[i].frame}, {"jpeg", base64(gallery.pictures[i].jpeg)}});
    list.push_back({{"scene", gallery.cell->scene},
                    {"variant", gallery.cell->variant},
                    {"seed", gallery.cell->seed},
                    {"available", gallery.pictures.size()},
                    {"frames", frames}});
  }
  return list.dump();
}

}  // namespace uniquadric
