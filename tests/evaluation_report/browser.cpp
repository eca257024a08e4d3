#include "tests/evaluation_report/browser.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <cstdlib>
#include <sstream>

#include "core/base/files.h"
#include "core/base/text.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace fs = std::filesystem;

std::optional<fs::path> find_chromium() {
  if (const char* named = std::getenv("UNIQUADRIC_CHROMIUM")) return fs::path(named);
  const char* path = std::getenv("PATH");
  for (const std::string_view folder : split(path ? path : "", ':'))
    for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
      if (fs::exists(fs::path(folder) / name)) return fs::path(folder) / name;
  return std::nullopt;
}

namespace {

// Headless, with its files in `folder`. No sandbox: it needs rights that a container seldom gives, and the
// page is ours. No service of the browser's own may ask the network.
std::string browser_command(const fs::path& chromium, const std::string& folder) {
  return fmt::format(
      "timeout 120 '{}' --headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader "
      "--disable-quic --no-first-run "
      "--disable-background-networking --disable-component-update --disable-sync "
      "--user-data-dir='{}/profile' --virtual-time-budget=10000 ",
      chromium.string(), folder);
}

}  // namespace

BrowserRun run_in_browser(const fs::path& chromium, const fs::path& page, int width_px, int height_px,
                          bool dark) {
  const TempFolder temp;
  const std::string base = temp.path().string();
  const std::string command =
      browser_command(chromium, base) +
      fmt::format(
          "--window-size={},{} --blink-settings=preferredColorScheme={} "
          "--enable-logging=stderr --dump-dom 'file://{}' >'{}/out' 2>'{}/err' </dev/null",
          width_px, height_px, dark ? 0 : 1, fs::absolute(page).string(), base, base);
  const int status = std::system(command.c_str());
  BrowserRun run{
      WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status), read_text(temp.path() / "out"), {}};
  std::istringstream lines(read_text(temp.path() / "err"));
  for (std::string line; std::getline(lines, line);)
    if (line.find(":CONSOLE") != line.npos) run.console.push_back(line);
  return run;
}

bool print_in_browser(const fs::path& chromium, const fs::path& page, const fs::path& pdf) {
  const TempFolder temp;
  const std::string command =
      browser_command(chromium, temp.path().string()) +
      fmt::format("--no-pdf-header-footer --print-to-pdf='{}' 'file://{}' >/dev/null 2>&1 </dev/null",
                  pdf.string(), fs::absolute(page).string());
  return std::system(command.c_str()) == 0 && fs::exists(pdf);
}

}  // namespace uniquadric
