// Too little memory for `evaluate`: it says so or succeeds, and no signal ends it.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "core/base/files.h"
#include "core/base/random.h"
#include "core/sequence/ply.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// A box that stands still, with points about it: Embree searches both.
void write_tracks(const fs::path& truth, const fs::path& estimate) {
  std::string poses;
  for (int k = 0; k < 5; ++k) poses += fmt::format("{} {} {} 0 0 0 0 1\n", 0.1 * k, 0.1 * k, 0.02 * k * k);
  for (const fs::path& folder : {truth, estimate}) {
    fs::create_directories(folder / "objects");
    write_text(folder / "camera.tum", poses);
    write_text(folder / "objects/1.tum", poses);
  }
  write_text(truth / "objects.yaml",
             "schema: 1\nobjects:\n  - {id: 1, name: a, shape: box, semi_axes_m: [1, 2, 3]}\n");
  write_text(estimate / "objects.yaml", "1: {size_m: [2, 4, 6]}\n");
  RandomStream random(1, "points");
  SurfaceFile points;
  for (int k = 0; k < 100'000; ++k)
    points.points.emplace_back(random.normal(), 2 * random.normal(), 3 * random.normal());
  write_surface_ply(estimate / "objects/1.ply", points, "");
}

TEST(Memory, EvaluateEndsByNoSignalWhateverIsLeft) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer needs terabytes of addresses";
#endif
  const TempFolder temp;
  const fs::path truth = temp.path() / "truth", estimate = temp.path() / "estimate";
  write_tracks(truth, estimate);
  const auto exit_code = [&](const std::string& limit) {
    const std::string command =
        fmt::format("ulimit -v {}; exec {} evaluate {} {} {} --force --quiet --threads 2 >/dev/null 2>{}",
                    limit, UNIQUADRIC_PROGRAM, truth.string(), estimate.string(),
                    (temp.path() / "out").string(), (temp.path() / "said").string());
    const int status = std::system(("bash -c '" + command + "'").c_str());
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  };
  ASSERT_EQ(exit_code("unlimited"), 0) << read_text(temp.path() / "said");
  int refused = 0;
  for (int limit_kb = 100'000; limit_kb <= 400'000; limit_kb += 5'000) {
    const int code = exit_code(std::to_string(limit_kb));
    EXPECT_LT(code, 128) << limit_kb << " kB: " << read_text(temp.path() / "said");
    refused += code == 3;
    if (code == 3) {
      const std::string said =
          read_text(temp.path() / "said");  // Embree's own threads do not say what failed
      EXPECT_TRUE(said == "uniquadric: out of memory\n" || said.find("Embree: error 1 ") != said.npos)
          << limit_kb << " kB: " << said;
    }
  }
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace uniquadric
