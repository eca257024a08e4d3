#include "core/base/yaml_bounds.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <vector>

#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/base/utf8.h"

namespace uniquadric {
namespace {

// ours: the largest file that is not a bomb, a bench of ten thousand seeds, has a twentieth of the nodes
constexpr std::int64_t kMostNodes = 200'000;
constexpr int kMostLevels = 64;

// Counts nodes and levels as they would be if every alias were written out.
class Bounds final : public YAML::EventHandler {
 public:
  explicit Bounds(const std::filesystem::path& name) : name_(name) {}

  void OnDocumentStart(const YAML::Mark&) override { anchors_.clear(); }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { leaf(mark, anchor); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                const std::string& value) override {
    if (!is_utf8(value)) fail(mark, "a text that is not UTF-8");
    leaf(mark, anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto known = anchors_.find(anchor);
    if (known == anchors_.end()) fail(mark, "an alias within what it stands for");
    add(mark, known->second);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, anchor);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  struct Size {
    std::int64_t nodes = 1;
    int levels = 0;  // below the node itself
  };
  struct Open {
    YAML::anchor_t anchor;
    Size size;
  };

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& what) const {
    throw InputError(name_, mark.line + 1, what);
  }
  void leaf(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (anchor != YAML::NullAnchor) anchors_[anchor] = {};
    add(mark, {});
  }
  // Once before its items, of which there may be none in sight of an end.
  void open(const YAML::Mark& mark, YAML::anchor_t anchor) {
    add(mark, {});
    open_.push_back({anchor, {}});
  }
  void close() {
    const Open done = open_.back();
    open_.pop_back();
    if (done.anchor != YAML::NullAnchor) anchors_[done.anchor] = done.size;
    if (open_.empty()) return;
    Size& parent = open_.back().size;
    parent.nodes += done.size.nodes - 1;  // itself counted when it was opened
    parent.levels = std::max(parent.levels, done.size.levels + 1);
  }
  void add(const YAML::Mark& mark, const Size& size) {
    nodes_ += size.nodes;
    if (nodes_ > kMostNodes)
      fail(mark, fmt::format("more than {} values, those that aliases stand for counted", kMostNodes));
    if (static_cast<int>(open_.size()) + size.levels >= kMostLevels)
      fail(mark, fmt::format("nested more than {} levels deep", kMostLevels));
    if (open_.empty()) return;
    Size& parent = open_.back().size;
    parent.nodes += size.nodes;
    parent.levels = std::max(parent.levels, size.levels + 1);
  }

  const std::filesystem::path& name_;
  std::int64_t nodes_ = 0;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Size> anchors_;
};

}  // namespace

void require_bounded_yaml(const std::string& text, const std::filesystem::path& name) {
  if (text.size() > kYamlFile.most_bytes)
    throw InputError(name, fmt::format("is longer than {} MiB", kYamlFile.most_bytes >> 20));
  Bounds bounds(name);
  std::istringstream stream(text);
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(bounds)) {
    }
  } catch (const YAML::Exception&) {  // what is wrong is said where it is read
  }
}

}  // namespace uniquadric
