#include "evaluation/report/figures.h"

#include <gtest/gtest.h>
#include <libdeflate.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "core/base/error.h"
#include "core/base/files.h"
#include "evaluation/report/report.h"
#include "evaluation/report/svg_colours.h"
#include "tests/evaluation_report/fabricated_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

std::vector<PictureLine> lines_of(const Picture& picture, LineKind kind) {
  std::vector<PictureLine> lines;
  for (const auto& part : picture.parts)
    if (const auto* line = std::get_if<PictureLine>(&part); line && line->kind == kind)
      lines.push_back(*line);
  return lines;
}

std::vector<NamedPicture> all_figures(const TempFolder& folder) {
  const Results results = read_results(folder.path());
  return figures_of(results, summarize(results));
}

TEST(Figures, HaveALineAVariantInItsColour) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 20, .overlays = 0});
  const std::vector<NamedPicture> figures = all_figures(folder);
  const auto found = std::ranges::find(figures, "cube_cuboid_cube_ape_translation_m", &NamedPicture::name);
  ASSERT_NE(found, figures.end());
  int variants[2] = {};
  for (const PictureLine& line : lines_of(found->picture, LineKind::coloured))
    for (std::size_t v = 0; v < 2; ++v)
      if (line.colour == kLightSvg.variant[v] && line.points.size() > 2) {
        ++variants[v];
        EXPECT_EQ(line.points.size(), 20u);
        EXPECT_TRUE(std::ranges::is_sorted(line.points, {}, &PicturePoint::x));
      }
  EXPECT_EQ(variants[0], 1);
  EXPECT_EQ(variants[1], 1);
}

// The boxes of a picture by their colour: middles of small ones, which are runs, and of large ones, the
// means.
TEST(Figures, SetVariantsSideBySide) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.seeds = 4, .frames = 20, .overlays = 0, .with_failure = false});
  const std::vector<NamedPicture> figures = all_figures(folder);
  const auto found =
      std::ranges::find(figures, "cube_cuboid_cube_ape_translation_rmse_m_variants", &NamedPicture::name);
  ASSERT_NE(found, figures.end());
  std::map<std::string, std::vector<double>> runs, means;
  for (const auto& part : found->picture.parts)
    if (const auto* box = std::get_if<PictureBox>(&part))
      (box->width < 5 ? runs : means)[box->colour].push_back(box->corner.x + box->width / 2);
  const std::string other = kLightSvg.variant[0], ours = kLightSvg.variant[1];
  ASSERT_EQ(runs.size(), 2u);
  ASSERT_EQ(runs[ours].size(), 4u);  // 0.01 s and 0.5 s: by their logarithm, 50 times apart
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(runs[other][i] - runs[ours][i], runs[other][0] - runs[ours][0], 1e-9);
  EXPECT_NEAR((runs[ours][3] - runs[ours][0]) / (runs[other][0] - runs[ours][0]), std::log(4) / std::log(50),
              1e-9);
  EXPECT_NEAR((means[ours].at(0) - runs[ours][0]) / (runs[other][0] - runs[ours][0]),
              std::log(2.5) / std::log(50), 1e-9);
}

TEST(Figures, HaveTheRangeErrorsOfLidar) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Results results;
  LidarRoutes routes;
  routes.scene = "car";
  routes.matched = 10;
  routes.errors = {{-kInfinity, -0.1, 3}, {-0.1, 0, 2}, {0, 0.1, 4}, {0.1, kInfinity, 1}};
  results.lidar = {routes};
  const std::vector<NamedPicture> figures = figures_of(results, {});
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0].name, "car_range_error");
  const auto lines = lines_of(figures[0].picture, LineKind::coloured);
  ASSERT_EQ(lines.size(), 1u);
  ASSERT_EQ(lines[0].points.size(), 2u);                  // the outer cells have no middle
  EXPECT_GT(lines[0].points[0].y, lines[0].points[1].y);  // 20 % and 40 %, upwards
}

TEST(Figures, KeepTheirTextInside) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 20, .overlays = 0});
  for (const NamedPicture& figure : all_figures(folder)) {
    if (!figure.name.ends_with("_variants")) continue;
    std::set<std::string> ticks;
    std::size_t count = 0;
    for (const auto& part : figure.picture.parts) {
      const auto* text = std::get_if<PictureText>(&part);
      if (!text) continue;
      const double width = 8 * static_cast<double>(text->text.size());  // of a wide letter each
      if (text->anchor == TextAnchor::start && text->kind != TextKind::title) {
        EXPECT_LE(text->at.x + width, figure.picture.width) << figure.name << text->text;
      }
      if (text->kind != TextKind::tick) continue;
      ticks.insert(text->text);
      ++count;
    }
    EXPECT_EQ(ticks.size(), count) << figure.name;  // no number twice
  }
}

TEST(Figures, LeaveWhatIsNotTheirs) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 20, .overlays = 0});
  const fs::path figures = folder.path() / "figures";
  fs::create_directories(figures);
  write_text(figures / "notes.txt", "mine");
  write_text(figures / "mine.svg", "mine");
  write_text(folder.path() / "mine.svg", "mine");
  write_text(figures / "of_before.svg", "");
  write_text(figures / "figures.txt", "of_before.svg\n../mine.svg\n");
  write_report(folder.path());  // made again: they were there before
  EXPECT_EQ(read_text(figures / "notes.txt") + read_text(figures / "mine.svg"), "minemine");
  EXPECT_TRUE(fs::exists(folder.path() / "mine.svg"));
  EXPECT_FALSE(fs::exists(figures / "of_before.svg"));
  EXPECT_NE(read_text(figures / "figures.txt").find("cube_cuboid_cube_ape_translation_m.pdf\n"),
            std::string::npos);
  fs::remove_all(figures);
  fs::remove(folder.path() / "report.html");
  write_text(figures, "a file");
  EXPECT_THROW(write_report(folder.path(), {.figures = true}), InputError);
  EXPECT_EQ(read_text(figures), "a file");
  EXPECT_FALSE(fs::exists(folder.path() / "report.html"));
}

TEST(Figures, HaveNamesThatFileSystemsTake) {
  Results results;
  for (const char* scene : {"a", "b"}) {
    LidarRoutes& routes = results.lidar.emplace_back();
    routes.scene = std::string(300, 'x') + scene;
    routes.errors = {{0, 0.1, 4}};
  }
  const std::vector<NamedPicture> figures = figures_of(results, {});
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_NE(figures[0].name, figures[1].name);
  EXPECT_LT(figures[1].name.size(), 250u);
}

// The same bytes each time, of names that cannot leave the folder.
TEST(Figures, AreWrittenAsSvgAndPdf) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 20, .overlays = 0});
  write_report(folder.path(), {.figures = true});
  const fs::path pdf = folder.path() / "figures/cube_cuboid_cube_iou3d.pdf";
  const std::string bytes = read_text(pdf);
  EXPECT_TRUE(bytes.starts_with("%PDF-1."));
  EXPECT_NE(bytes.find("%%EOF"), std::string::npos);
  std::size_t svgs = 0, pdfs = 0;
  for (const auto& file : fs::directory_iterator(folder.path() / "figures")) {
    svgs += file.path().extension() == ".svg";
    pdfs += file.path().extension() == ".pdf";
  }
  EXPECT_EQ(svgs, all_figures(folder).size());
  EXPECT_EQ(pdfs, svgs);
  EXPECT_GT(svgs, 4u);
  write_report(folder.path(), {.figures = true});
  EXPECT_EQ(read_text(pdf), bytes);
}

// What a PDF file draws: its streams, inflated.
std::string drawing_in(const std::string& pdf) {
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> inflate(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  std::string all, part(1 << 20, '\0');
  const std::string begin = "\nstream\n";
  for (std::size_t at = 0; (at = pdf.find(begin, at)) != std::string::npos;) {
    at += begin.size();
    std::size_t taken = 0, made = 0;
    if (libdeflate_zlib_decompress_ex(inflate.get(), pdf.data() + at, pdf.size() - at, part.data(),
                                      part.size(), &taken, &made) == LIBDEFLATE_SUCCESS)
      all += part.substr(0, made);
  }
  return all;
}

TEST(PicturePdf, ALineBeginsAtItsFirstPointWhateverCameBefore) {
  Picture picture{400, 300, "", {}};
  picture.parts.emplace_back(PictureText{TextKind::plain, TextAnchor::start, {200, 100}, "words"});
  picture.parts.emplace_back(PictureLine{LineKind::grid, {{12, 16}, {300, 200}}, ""});
  const std::string drawing = drawing_in(picture_pdf(picture));
  EXPECT_NE(drawing.find("9 12 m 225 150 l S"), std::string::npos) << drawing;
}

TEST(PicturePdf, IsAsLargeAsThePictureAndHoldsItsText) {
  Picture picture{400, 300, "A picture", {}};
  picture.parts.emplace_back(PictureText{TextKind::plain, TextAnchor::middle, {200, 100}, "words"});
  picture.parts.emplace_back(PictureLine{LineKind::reference, {{10, 10}, {300, 200}}, ""});
  picture.parts.emplace_back(PictureBox{{5, 5}, 10, 10, "#ff0000"});
  const std::string bytes = picture_pdf(picture);
  EXPECT_NE(bytes.find("/MediaBox [ 0 0 300 225 ]"), std::string::npos);  // three quarters of a point a unit
  EXPECT_NE(bytes.find("/Type /Font"), std::string::npos);
  EXPECT_NE(bytes.find("(A picture)"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
