#include "harness/rosbag/static_tree.h"

#include <map>

namespace uniquadric {
namespace {

// Names of frames with and without a leading slash are one name, as tf2 has it.
std::string plain(const std::string& frame) {
  return frame.starts_with('/') ? frame.substr(1) : frame;
}

}  // namespace

std::optional<Pose> static_transform(const std::vector<BagTransform>& transforms, const std::string& target,
                                     const std::string& source) {
  std::map<std::string, Pose> target_from = {{plain(target), Pose{}}};
  for (bool is_growing = true; is_growing;) {
    is_growing = false;
    for (const BagTransform& transform : transforms) {
      const auto parent = target_from.find(plain(transform.parent)),
                 child = target_from.find(plain(transform.child));
      if (parent != target_from.end() && child == target_from.end())
        is_growing |=
            target_from.try_emplace(plain(transform.child), parent->second * transform.parent_from_child)
                .second;
      else if (parent == target_from.end() && child != target_from.end())
        is_growing |=
            target_from
                .try_emplace(plain(transform.parent), child->second * transform.parent_from_child.inverse())
                .second;
    }
  }
  const auto found = target_from.find(plain(source));
  if (found == target_from.end()) return std::nullopt;
  found->second.rotation.normalize();
  return found->second;
}

}  // namespace uniquadric
