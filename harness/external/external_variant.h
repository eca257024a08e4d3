#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/sequence/sequence.h"

namespace uniquadric {

/// A program of somebody else as a variant: what its file says (docs/own_system.md).
struct ExternalVariant {
  std::string name;
  std::filesystem::path folder;      ///< of the variant file, absolute: the program runs in it
  std::vector<std::string> command;  ///< with {sequence}, {out}, {seed}, {prompt} in it
  std::string layout = "native";     ///< what {sequence} is: native, or a format that `export` writes
  std::string result = "native";     ///< what {out} holds afterwards: native, or what `convert-result` reads
  std::vector<std::filesystem::path> inputs;  ///< files and folders it reads, absolute
  std::vector<std::filesystem::path> mounts;  ///< further folders it may read, whose content is not hashed
  std::vector<std::pair<std::string, std::string>> environment;
  double time_limit_s = 3600;
  double memory_limit_mb = 8000;
  double output_limit_mb = 2000;
  bool gpu = false;
  std::vector<std::string> sensors;  ///< that it needs (kSensorNames)
  std::string output = "causal";     ///< when its poses were known: at their frame, or `final`, at the end

  bool operator==(const ExternalVariant&) const = default;
};

/// Sensors that a variant can ask for. The camera's poses as another system knows them are hidden from a
/// program that does not ask for `given_camera`: in a simulation they are the truth.
inline constexpr const char* kSensorNames[] = {"rgb", "depth", "masks", "lidar", "imu", "given_camera"};

/// Those that a sequence has.
std::vector<std::string> sensors_of(const Sequence& sequence);

/// Those of `wanted` that `there` lacks.
std::vector<std::string> missing_sensors(const std::vector<std::string>& wanted,
                                         const std::vector<std::string>& there);

/// Whether the file has a key `command`. Throws InputError for what is no YAML.
bool is_external(const std::filesystem::path& variant_file);

/// Reads a variant file with a command. Files that arguments of the command name, relative to the variant
/// file, count as inputs. Throws InputError with file and line.
ExternalVariant load_external_variant(const std::filesystem::path& variant_file);

/// All options, resolved, without paths of this machine; with a hash of the inputs' bytes.
std::string external_yaml(const ExternalVariant& variant);

}  // namespace uniquadric
