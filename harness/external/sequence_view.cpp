#include "harness/external/sequence_view.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/folder_hashes.h"
#include "harness/export/export.h"

namespace uniquadric {
namespace fs = std::filesystem;

std::vector<fs::path> visible_entries(const fs::path& sequence, const ExternalVariant& variant) {
  const bool sees_camera = std::ranges::find(variant.sensors, "given_camera") != variant.sensors.end();
  std::vector<fs::path> entries;
  for (const auto& entry : fs::directory_iterator(sequence)) {
    const std::string name = entry.path().filename();
    if (name == kHashesFile || (name == "camera_given.tum" && !sees_camera)) continue;
    if (entry.is_symlink())
      throw InputError(entry.path(), "is a link, which an isolated program cannot follow");
    entries.push_back(entry.path());
  }
  std::ranges::sort(entries);
  return entries;
}

fs::path make_sequence_view(const fs::path& sequence, const ExternalVariant& variant,
                            const fs::path& folder) {
  const bool is_native = variant.layout == "native";
  const fs::path view = folder / "view" / "sequence";
  fs::create_directories(view);
  for (const fs::path& entry : visible_entries(sequence, variant)) {
    const fs::path target = view / entry.filename();
    if (is_native)
      fs::copy(entry, target, fs::copy_options::recursive);
    else if (fs::is_directory(entry))
      fs::create_directory_symlink(fs::absolute(entry), target);
    else
      fs::create_symlink(fs::absolute(entry), target);
  }
  if (is_native) return view;
  ExportOptions options;
  options.quiet = true;
  const fs::path exported = folder / "exported";
  export_sequence(variant.layout, view, exported, options);  // finds no truth beside the view
  return exported;
}

}  // namespace uniquadric
