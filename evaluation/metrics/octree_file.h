#pragma once

#include <filesystem>
#include <memory>

namespace octomap {
class OcTree;
}

namespace uniquadric {

/// Reads OctoMap's binary tree (.bt). Throws InputError with file, and line in the header, for what is no
/// such file, a tree without voxels, and data that are cut short, go deeper than 16 levels or go on behind
/// the tree: OctoMap itself would read them as something.
std::shared_ptr<const octomap::OcTree> read_octree(const std::filesystem::path& path);

}  // namespace uniquadric
