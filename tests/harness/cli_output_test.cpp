// What is there already is replaced when asked for alone, and an input never.
#include "tests/harness/cli_fixture.h"

namespace uniquadric {
namespace {

TEST_F(Cli, ARefusedOutputStaysAsItWas) {
  const fs::path scene = write("scene.yaml", small_scene_yaml());
  write("taken/precious.txt", "precious");
  const ProgramRun run = run_program({"simulate", scene, folder() / "taken", "--quiet"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("not empty"), std::string::npos);
  EXPECT_EQ(read_text(folder() / "taken/precious.txt"), "precious");
}

TEST_F(Cli, BenchWritesIntoNoForeignFolder) {
  const fs::path scene = write("small.yaml", small_scene_yaml());
  const fs::path variant = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/single_frame_obb.yaml";
  const fs::path bench = write(
      "b.yaml", "scenes: [small.yaml]\nvariants: [" + variant.string() + "]\nseeds: [1]\noverlays: 1\n");
  const fs::path taken = folder() / "taken", precious = write("taken/precious.txt", "precious");
  expect_refusal({"bench", bench, taken}, "taken: is not empty and holds no results of bench");
  EXPECT_EQ(std::distance(fs::directory_iterator(taken), {}), 1);
  expect_refusal({"bench", bench, taken, "--collect"}, "taken: is not empty and holds no results of bench");
  expect_refusal({"bench", bench, folder()}, "holds the input");
  fs::create_symlink(folder() / "nothing", folder() / "link");
  expect_refusal({"bench", bench, folder() / "link"}, "link: is a link to ");
  write("cut_short/bench.yaml", "");  // as one that was ended before its report has it
  write("begun/bench.yaml.partial", "");
  for (const auto& arguments :
       std::vector<std::vector<std::string>>{{"bench", bench, folder() / "cut_short", "--quiet"},
                                             {"bench", bench, folder() / "begun", "--quiet"}}) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_TRUE(fs::exists(fs::path(arguments[2]) / "report.md"));
  }
  EXPECT_EQ(read_text(precious), "precious");
}

// --force replaces a result, never what the result is made of.
TEST_F(Cli, ForceNeverReplacesAnInput) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  const fs::path sequence = data / "sequence", truth = data / "truth";
  const std::string before = folder_hash(folder());
  expect_refusal({"estimate", sequence, sequence, "--force"}, "sequence: is the input");
  expect_refusal({"estimate", sequence, data, "--force"}, "data: holds the input");
  expect_refusal({"estimate", sequence, sequence / "out"}, "out: lies inside the input");
  expect_refusal({"estimate", sequence, out(), "--perception", sequence}, "sequence: is the input");
  expect_refusal({"perceive", sequence, data, "--force"}, "data: holds the input");
  expect_refusal({"evaluate", truth, truth, truth, "--force"}, "truth: is the input");
  expect_refusal({"overlay", sequence, truth, data, "--force"}, "data: holds the input");
  expect_refusal({"export", "tum", sequence, sequence, "--force"}, "sequence: is the input");
  expect_refusal({"export", "tum", sequence, folder() / "exported", "--pixel-stride", "3"},
                 "tum has no strides");
  expect_refusal({"import", "tum", sequence, sequence, "--force"}, "sequence: is the input");
  expect_refusal({"simulate", scene, folder(), "--force"}, "holds the input");
  expect_refusal({"preview", scene, scene}, "scene.yaml: is the input");
  EXPECT_EQ(folder_hash(folder()), before);
}

// Nor what somebody else wrote, nor another kind of result.
TEST_F(Cli, ForceReplacesOnlyItsOwnKind) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  const fs::path sequence = data / "sequence", truth = data / "truth", thesis = folder() / "thesis";
  write("thesis/.git/HEAD", "ref: refs/heads/main");
  const std::string before = folder_hash(folder());
  expect_refusal({"evaluate", truth, truth, thesis, "--force"}, "thesis: was not written by this program");
  expect_refusal({"estimate", sequence, truth, "--force"}, "truth: was not written by this program");
  expect_refusal({"estimate", sequence, thesis, "--force"}, "thesis: was not written by this program");
  expect_refusal({"evaluate", truth, truth, data, "--force"}, "data: holds the input");
  expect_refusal({"simulate", scene, thesis, "--force"}, "thesis: was not written by this program");
  EXPECT_EQ(folder_hash(folder()), before);
  const fs::path exported = folder() / "exported";
  ASSERT_EQ(run_program({"export", "tum", sequence, exported, "--quiet"}).exit_code, 0);
  expect_refusal({"estimate", sequence, exported, "--force"},
                 "exported: holds another kind of result (export, not estimate)");
  EXPECT_EQ(run_program({"export", "tum", sequence, exported, "--quiet", "--force"}).exit_code, 0);
}

TEST_F(Cli, AnExistingFileNeedsForceAndMustBeAFile) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), mine = write("mine.txt", "mine");
  const fs::path tum = write("a.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n");
  const fs::path scores = write("scores.csv",
                                "sequence,object,variant,seed,metric,value,better,status\n"
                                "s,o,v,1,iou3d_ellipsoid_mean,0.5,higher,ok\n");
  fs::create_symlink(mine, folder() / "link.svg");
  const auto commands = [&](const fs::path& file) {
    return std::vector<std::vector<std::string>>{
        {"preview", scene, file},
        {"simulate", scene, out(), "--timing", file},
        {"compare", scores, scores, "--markdown", file},
    };
  };
  for (const auto& command : commands(mine))
    expect_refusal(command, "mine.txt: exists; give another name or --force");
  expect_refusal({"trajectory", tum, tum, "--plot", folder() / "link.svg", "--force"},
                 "is not a regular file");
  for (auto command : {commands(mine)[0], commands(mine)[1], {"generate", "room", mine}}) {
    command.push_back("--force");
    expect_refusal(command, "so --force does not replace it");
  }
  const fs::path drawn = folder() / "drawn.yaml";
  for (const char* family : {"room", "tabletop"})
    EXPECT_EQ(run_program({"generate", family, drawn, "--force"}).exit_code, 0);
  for (auto command : commands("/dev/null")) {
    command.push_back("--force");
    expect_refusal(command, "/dev/null: exists and is not a regular file");
  }
  EXPECT_EQ(read_text(mine), "mine");
}

// Neither a scene that was edited by hand, nor one that does not say how it was drawn.
TEST_F(Cli, ForceKeepsADrawnSceneThatWasEdited) {
  const fs::path drawn = folder() / "drawn.yaml";
  const std::vector<std::string> command = {"generate", "room", drawn, "--force"};
  ASSERT_EQ(run_program(command).exit_code, 0);
  const std::string text = read_text(drawn);
  const std::size_t note = text.find(", body "), body = text.find("frames: 300");
  ASSERT_LT(note, text.find('\n'));
  for (const auto& [edited, what] :
       {std::pair(std::string(text).replace(body, 11, "frames: 301"), "was edited since it was drawn"),
        {text + "# mine\n", "was edited since it was drawn"},
        {text.substr(0, text.find('\n')), "was edited since it was drawn"},
        {std::string(text).erase(note, 23), "does not say how it was drawn"}}) {
    write_text(drawn, edited);
    expect_refusal(command, std::string(what) + ", so --force does not replace it");
    EXPECT_EQ(read_text(drawn), edited);
  }
  write_text(drawn, text);
  EXPECT_EQ(run_program(command).exit_code, 0);
  EXPECT_EQ(read_text(drawn), text);
}

// A picture is what its name says, and so is a scene.
TEST_F(Cli, TheEndingSaysWhatIsWritten) {
  const fs::path scene = write("scene.yaml", small_scene_yaml());
  for (const auto& [name, begins] :
       {std::pair("a.png", kPngFile.begins), {"a.jpg", kJpegFile.begins}, {"a.jpeg", kJpegFile.begins}}) {
    for (const char* force : {"--quiet", "--force"}) {
      const ProgramRun run = run_program({"preview", scene, folder() / name, force});
      EXPECT_EQ(run.exit_code, 0) << run.err;
    }
    EXPECT_TRUE(read_text(folder() / name).starts_with(begins)) << name;
  }
  write("b.png", read_text(folder() / "a.jpg"));
  expect_refusal({"preview", scene, folder() / "b.png", "--force"}, "b.png: is no PNG picture");
  for (const char* name : {"c.gif", "c", "c.yaml"}) {
    expect_refusal({"preview", scene, folder() / name}, "a picture's name ends in .png, .jpg or .jpeg");
    EXPECT_FALSE(fs::exists(folder() / name));
  }
  for (const char* name : {"e.jpg", "e"}) {
    expect_refusal({"generate", "room", folder() / name}, "a scene's name ends in .yaml or .yml");
    EXPECT_FALSE(fs::exists(folder() / name));
  }
  EXPECT_EQ(run_program({"generate", "room", folder() / "e.yml"}).exit_code, 0);
}

TEST_F(Cli, AFullOutputIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  const fs::path scene = write("scene.yaml", small_scene_yaml());
  for (const std::string& command : {"info " + scene.string(), std::string("metric iou3d")}) {
    const std::string call = "echo nonsense | " UNIQUADRIC_PROGRAM " " + command + " >/dev/full 2>";
    EXPECT_EQ(std::system((call + (folder() / "err").string()).c_str()) >> 8, 2) << command;
    const std::string said = read_text(folder() / "err");
    EXPECT_NE(said.find("cannot be written: No space left on device"), std::string::npos) << said;
  }
}

TEST_F(Cli, MetricRefusesAnInputWithoutLines) {
  for (const auto& [input, why] :
       {std::pair{"</", "standard input is a folder"}, std::pair{"<&-", "standard input cannot be read"}}) {
    const std::string call = std::string(UNIQUADRIC_PROGRAM " metric iou3d ") + input + " 2>";
    EXPECT_EQ(std::system((call + (folder() / "err").string()).c_str()) >> 8, 2) << input;
    EXPECT_NE(read_text(folder() / "err").find(why), std::string::npos) << input;
  }
}

}  // namespace
}  // namespace uniquadric
