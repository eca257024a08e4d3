#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace uniquadric {

/// Chromium's executable: the variable UNIQUADRIC_CHROMIUM, or the first of its usual names in PATH. Nothing
/// where there is none: tests skip.
std::optional<std::filesystem::path> find_chromium();

/// What headless Chromium made of a page.
struct BrowserRun {
  int exit_code = 0;
  std::string document;              ///< the elements as they stand at the end
  std::vector<std::string> console;  ///< lines that the page's console got, errors of scripts among them
};

/// Opens `page` in a window of `width_px` x `height_px`, in dark colours or light ones; timers and frames run
/// for ten seconds of the page's own clock.
BrowserRun run_in_browser(const std::filesystem::path& chromium, const std::filesystem::path& page,
                          int width_px, int height_px, bool dark);

/// Prints `page` to the file `pdf`; whether that went well.
bool print_in_browser(const std::filesystem::path& chromium, const std::filesystem::path& page,
                      const std::filesystem::path& pdf);

}  // namespace uniquadric
