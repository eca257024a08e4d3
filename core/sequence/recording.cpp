#include "core/sequence/recording.h"

#include <algorithm>
#include <cctype>
#include <functional>

namespace uniquadric {

std::string recording_name(const std::filesystem::path& recording) {
  const std::filesystem::path folder = std::filesystem::weakly_canonical(recording);
  std::string name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
  const auto is_plain = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-' || c == '.'; };
  std::replace_if(name.begin(), name.end(), std::not_fn(is_plain), '_');
  return name.empty() ? "recording" : name;
}

double nominal_rate_hz(const std::vector<std::int64_t>& stamps_ns, double fallback_hz) {
  std::vector<std::int64_t> intervals_ns;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i) intervals_ns.push_back(stamps_ns[i] - stamps_ns[i - 1]);
  if (intervals_ns.empty()) return fallback_hz;
  const auto middle = intervals_ns.begin() + std::ssize(intervals_ns) / 2;
  std::nth_element(intervals_ns.begin(), middle, intervals_ns.end());
  return 1e9 / static_cast<double>(*middle);
}

}  // namespace uniquadric
