#include "evaluation/metrics/octree_file.h"

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <sstream>
#include <string_view>

#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {

constexpr std::string_view kFirstLine = "# Octomap OcTree binary file";
constexpr double kLeastEdge_m = 1e-6, kMostEdge_m = 1e6;  // ours: no map has such cells
constexpr int kLevels = 16;                               // of an OcTree below its root

struct Header {
  double resolution_m = 0;
  bool empty = false;
  std::size_t end = 0;  // where the data begin
};

void read_entry(const std::filesystem::path& path, int line, std::string_view text, Header& header) {
  const auto fields = split(text);
  const std::string_view key = fields[0], value = fields.size() == 2 ? fields[1] : "";
  if (key == "id") {
    if (value != "OcTree") throw InputError(path, line, fmt::format("id: '{}' is not OcTree", value));
  } else if (key == "size") {
    const auto size = parse_integer(value);
    if (!size || *size < 0) throw InputError(path, line, "size: expected a count");
    header.empty = *size == 0;
  } else if (key == "res") {
    header.resolution_m = parse_double(value).value_or(0);
    if (!(header.resolution_m >= kLeastEdge_m && header.resolution_m <= kMostEdge_m))
      throw InputError(path, line,
                       fmt::format("res: expected a number from {} to {}", kLeastEdge_m, kMostEdge_m));
  } else {
    throw InputError(path, line, fmt::format("'{}' is none of id, size, res, data", key.substr(0, 20)));
  }
}

Header read_header(const std::filesystem::path& path, std::string_view bytes) {
  if (!bytes.starts_with(kFirstLine)) throw InputError(path, 1, fmt::format("expected '{}'", kFirstLine));
  Header header;
  for (int line = 1; header.end < bytes.size(); ++line) {
    const std::size_t stop = bytes.find('\n', header.end);
    if (stop == bytes.npos) break;
    const std::string_view text = bytes.substr(header.end, stop - header.end);
    header.end = stop + 1;
    if (text == "data") {
      if (header.resolution_m == 0) throw InputError(path, "the header has no res");
      return header;
    }
    if (!split(text).empty() && !text.starts_with('#')) read_entry(path, line, text, header);
  }
  throw InputError(path, "the header has no data");
}

// Follows the tree through its bytes: two a node with children, two bits a child.
struct Structure {
  const std::filesystem::path& path;
  std::string_view bytes;
  std::size_t at = 0;

  void node(int level) {
    if (at + 2 > bytes.size()) throw InputError(path, "is cut short within its data");
    const unsigned children =
        static_cast<unsigned char>(bytes[at]) | static_cast<unsigned char>(bytes[at + 1]) << 8;
    if (children == 0)
      throw InputError(path, fmt::format("byte {} of the data: a node without children", at));
    if (level == kLevels) throw InputError(path, fmt::format("has more than {} levels", kLevels));
    at += 2;
    for (int child = 0; child < 8; ++child)
      if ((children >> 2 * child & 3) == 3) node(level + 1);
  }
};

}  // namespace

std::shared_ptr<const octomap::OcTree> read_octree(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kPointFile);
  const Header header = read_header(path, bytes);
  Structure structure{path, std::string_view(bytes).substr(header.end)};
  if (header.empty) throw InputError(path, "has no voxels");
  structure.node(0);
  if (structure.at != structure.bytes.size())
    throw InputError(path, fmt::format("{} bytes after the tree", structure.bytes.size() - structure.at));
  auto tree = std::make_shared<octomap::OcTree>(header.resolution_m);
  std::istringstream data(bytes.substr(header.end));
  tree->readBinaryData(data);
  return tree;
}

}  // namespace uniquadric
