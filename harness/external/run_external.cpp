#include "harness/external/run_external.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>

#include "core/base/apart.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/folder_hashes.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/base/warning.h"
#include "core/import/result.h"
#include "core/sequence/calibration.h"
#include "harness/external/process_tree.h"
#include "harness/external/sandbox.h"
#include "harness/external/sequence_view.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// Folders that the program writes to, gone when it has ended.
class Workplace {
 public:
  explicit Workplace(fs::path folder) : folder_(std::move(folder)), lock_(folder_, folder_) {
    for (const char* part : {"out", "tmp", "shm"}) fs::create_directories(folder_ / part);
  }
  ~Workplace() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;
  const fs::path& path() const { return folder_; }

 private:
  fs::path folder_;
  FolderLock lock_;  // while the process lives
};

constexpr const char* kTemporaryName = "uniquadric-cell-";

// Of processes that were killed: nobody holds them, and they are older than one that is being made.
void clear_temporary_folders() {
  constexpr std::chrono::minutes kYoung{1};
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(fs::temp_directory_path(), ignored)) {
    const bool is_ours = entry.path().filename().string().starts_with(kTemporaryName);
    if (is_ours && entry.last_write_time(ignored) + kYoung < fs::file_time_type::clock::now() &&
        !FolderLock::is_held(entry.path()))
      fs::remove_all(entry.path(), ignored);
  }
}

fs::path new_temporary_folder() {
  clear_temporary_folders();
  std::string pattern = (fs::temp_directory_path() / (kTemporaryName + std::string("XXXXXX"))).string();
  if (!mkdtemp(pattern.data())) throw_unwritable(pattern);
  return pattern;
}

// The truth stands beside the sequence, results of others beside `out`.
void refuse_to_show_the_truth(const ExternalVariant& variant, const fs::path& sequence) {
  const fs::path data = fs::canonical(sequence).parent_path();
  if (is_in_system(data))
    throw InputError(
        sequence,
        fmt::format("lies in a folder of the system, which {} could read: move it elsewhere", variant.name));
  for (const auto* list : {&variant.inputs, &variant.mounts})
    for (const fs::path& path : *list)
      if (const fs::path target = fs::weakly_canonical(path); holds(target, data) || holds(data, target))
        throw InputError(path,
                         fmt::format("is an input or mount of {} and holds, or lies in, the folder of the "
                                     "sequence: its program would see the truth",
                                     variant.name));
}

void require_sensors(const ExternalVariant& variant, const Sequence& sequence) {
  const auto missing = missing_sensors(variant.sensors, sensors_of(sequence));
  if (!missing.empty())
    throw InputError(sequence.folder,
                     fmt::format("has no {}, which {} needs", fmt::join(missing, ", "), variant.name));
}

struct Places {
  fs::path sequence, out, prompt, temporary;
};

std::vector<std::string> filled_in(const ExternalVariant& variant, const Places& places, std::uint64_t seed) {
  const std::pair<std::string, std::string> values[] = {{"{sequence}", places.sequence},
                                                        {"{out}", places.out},
                                                        {"{seed}", std::to_string(seed)},
                                                        {"{prompt}", places.prompt}};
  std::vector<std::string> command = variant.command;
  for (std::string& argument : command)
    for (const auto& [placeholder, value] : values)
      for (std::size_t at = 0; (at = argument.find(placeholder, at)) != std::string::npos; at += value.size())
        argument.replace(at, placeholder.size(), value);
  return command;
}

std::vector<std::string> environment_of(const ExternalVariant& variant, const fs::path& temporary) {
  std::vector<std::string> environment = {"HOME=" + temporary.string(), "TMPDIR=" + temporary.string()};
  for (const char* name : {"PATH", "LANG", "LC_ALL"})
    if (const char* value = std::getenv(name)) environment.push_back(fmt::format("{}={}", name, value));
  for (const auto& [name, value] : variant.environment) {
    std::erase_if(environment, [&](const std::string& e) { return e.starts_with(name + "="); });
    environment.push_back(fmt::format("{}={}", name, value));
  }
  return environment;
}

TreeLimits limits_of(const ExternalVariant& variant, const fs::path& output) {
  return {variant.time_limit_s, variant.memory_limit_mb, variant.output_limit_mb, output};
}

// What the program can see of the machine, and what it is told of that.
TreeCommand isolated_command(const ExternalVariant& variant, const ExternalOptions& options,
                             const fs::path& sequence, const fs::path& work) {
  Sandbox sandbox{{}, work / "out", work, variant.folder, variant.gpu};
  if (variant.layout == "native") {
    for (const fs::path& entry : visible_entries(sequence, variant))
      sandbox.readable.emplace_back(fs::absolute(entry), fs::path(kInsideSequence) / entry.filename());
  } else {
    for (const auto& entry : fs::directory_iterator(make_sequence_view(sequence, variant, work)))
      sandbox.readable.emplace_back(entry.path(), fs::path(kInsideSequence) / entry.path().filename());
  }
  for (const auto* list : {&variant.inputs, &variant.mounts})
    for (const fs::path& path : *list) sandbox.readable.emplace_back(path, path);
  if (!options.prompt.empty()) sandbox.readable.emplace_back(fs::canonical(options.prompt), kInsidePrompt);
  const Places inside{kInsideSequence, kInsideOut, options.prompt.empty() ? "" : kInsidePrompt, "/tmp"};
  return {isolated(filled_in(variant, inside, options.seed), sandbox), environment_of(variant, "/tmp"), "/"};
}

TreeCommand open_command(const ExternalVariant& variant, const ExternalOptions& options,
                         const fs::path& sequence, const fs::path& work) {
  const fs::path prompt = options.prompt.empty() ? fs::path() : work / options.prompt.filename();
  if (!prompt.empty()) fs::copy(options.prompt, prompt, fs::copy_options::recursive);
  const Places places{make_sequence_view(sequence, variant, work), work / "out", prompt, work / "tmp"};
  return {filled_in(variant, places, options.seed), environment_of(variant, work / "tmp"), variant.folder};
}

// A link could show what the program itself could not see, and a pipe would never end.
void require_plain_files(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_symlink() || !(entry.is_regular_file() || entry.is_directory()))
      throw InputError(entry.path().lexically_relative(folder), "is neither a file nor a folder");
}

// Results in the camera's frame are placed by the given poses where the program may know them, too.
Tracks read_output(const ExternalVariant& variant, const fs::path& output, Sequence sequence) {
  if (std::ranges::find(variant.sensors, "given_camera") == variant.sensors.end())
    sequence.given_camera.reset();
  try {
    require_plain_files(output);
    return read_result(output, variant.result, sequence);
  } catch (const InputError& e) {
    std::string what = e.what();  // without the folder that is gone when this is read
    for (const char* end : {"/", ": "})
      for (const std::string folder = output.string() + end; what.find(folder) != std::string::npos;)
        what.erase(what.find(folder), folder.size());
    throw InputError(fmt::format("{}: its result: {}", variant.name, what));
  }
}

std::string run_yaml(const ExternalVariant& variant, const ExternalOptions& options, const Sequence& sequence,
                     bool is_isolated) {
  std::string text = fmt::format("schema: 1\nprogram: {}\nsequence: {}\n", yaml_quoted(kProgram),
                                 yaml_quoted(sequence.name));
  if (!sequence.scene_hash.empty()) text += fmt::format("scene_hash: \"{}\"\n", sequence.scene_hash);
  text += fmt::format("seed: {}\nprompts: {}\nisolation: {}\nvariant:\n", options.seed,
                      yaml_quoted(options.prompt.empty() ? "everything" : options.prompt.filename().string()),
                      is_isolated ? "bubblewrap" : "none");
  const std::string yaml = external_yaml(variant);
  for (const std::string_view line : split(yaml, '\n'))
    if (!line.empty()) text += fmt::format("  {}\n", line);
  return text;
}

// `output`: when its poses were known.
void keep_output(const ExternalVariant& variant, const fs::path& from, const Sequence& sequence,
                 const std::string& output, const std::string& run, const fs::path& to) {
  fs::create_directories(to);
  write_estimate(to, read_output(variant, from, sequence));
  write_camera_yaml(to / "camera.yaml", sequence.camera);
  write_text(to / "run.yaml", fmt::format("output: {}\n", output) + run);
}

}  // namespace

void run_external(const fs::path& sequence_folder, const ExternalVariant& variant,
                  const ExternalOptions& options, const fs::path& out) {
  if (options.verify) require_unchanged_texts(sequence_folder);
  const Sequence sequence = open_sequence(sequence_folder);
  require_sensors(variant, sequence);
  refuse_to_show_the_truth(variant, sequence_folder);
  PendingFolder pending(out, "estimate", options.force);
  const bool is_isolated = can_isolate();
  if (!is_isolated)
    warn(fmt::format("{} is not isolated: bubblewrap (bwrap) cannot run here, so it could open the truth",
                     variant.name));
  const Workplace work(is_isolated ? fs::absolute(pending.path() / "work") : new_temporary_folder());
  const TreeCommand command = is_isolated ? isolated_command(variant, options, sequence_folder, work.path())
                                          : open_command(variant, options, sequence_folder, work.path());
  const TreeResult result = run_tree(command, limits_of(variant, work.path()));
  if (!result.failure.empty()) throw InputError(fmt::format("{}: {}", variant.name, result.failure));
  const std::string run = run_yaml(variant, options, sequence, is_isolated);
  keep_output(variant, work.path() / "out", sequence, variant.output, run, pending.path());
  for (const char* output : kLaterOutputs)
    if (fs::is_directory(work.path() / "out" / output))
      keep_output(variant, work.path() / "out" / output, sequence, output, run, pending.path() / output);
  write_usage(pending.path(), result.usage);
  fs::remove_all(work.path());
  pending.commit();
}

}  // namespace uniquadric
