// A perception that is kept: whose it is, and when it is made anew.
#include "tests/harness/cli_fixture.h"

namespace uniquadric {
namespace {

TEST_F(Cli, AForeignFolderIsNotTakenForAKeptPerception) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  const fs::path precious = write("taken/precious.txt", "precious");
  expect_refusal({"estimate", data / "sequence", out(), "--quiet", "--perception", folder() / "taken"},
                 "taken: is not empty and holds no perception");
  EXPECT_EQ(read_text(precious), "precious");
  const fs::path kept = folder() / "kept";
  ASSERT_EQ(run_program({"perceive", data / "sequence", kept, "--quiet"}).exit_code, 0);
  const ProgramRun again = run_program({"perceive", data / "sequence", kept, "--quiet", "--seed", "7"});
  EXPECT_EQ(again.exit_code, 0) << again.err;  // an older result is replaced
  const fs::path notes = write("kept/notes.txt", "mine");
  ASSERT_EQ(run_program({"perceive", data / "sequence", kept, "--quiet", "--seed", "7"}).exit_code, 0)
      << "kept";
  expect_refusal({"perceive", data / "sequence", kept, "--quiet", "--seed", "8"},
                 "notes.txt: is no part of the kept perception");
  EXPECT_EQ(read_text(notes), "mine");
}

// Of the same sequence it is renewed, of another one it is a result like any other.
TEST_F(Cli, APerceptionOfAnotherSequenceIsReplacedByForceAlone) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), kept = folder() / "kept";
  const fs::path one = folder() / "one", two = folder() / "two";
  ASSERT_EQ(run_program({"simulate", scene, one, "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_program({"simulate", scene, two, "--quiet", "--seed", "1"}).exit_code, 0);
  ASSERT_EQ(run_program({"perceive", one, kept, "--quiet"}).exit_code, 0);
  const std::string before = folder_hash(kept);
  expect_refusal({"estimate", two, out(), "--quiet", "--perception", kept},
                 "kept: holds the perception of another sequence (small)");
  expect_refusal({"perceive", two, kept, "--quiet"},
                 "kept: holds the perception of another sequence (small)");
  EXPECT_EQ(folder_hash(kept), before);
  const ProgramRun own =
      run_program({"estimate", one, out(), "--quiet", "--seed", "3", "--perception", kept});
  EXPECT_EQ(own.exit_code, 0) << own.err;
  EXPECT_NE(folder_hash(kept), before);
  const ProgramRun forced = run_program({"estimate", two, out(), "--quiet", "--force", "--perception", kept});
  EXPECT_EQ(forced.exit_code, 0) << forced.err;
  fs::remove_all(out());
  expect_refusal({"perceive", one, kept, "--quiet"}, "another sequence");  // it is of the other one now
}

// Perception samples too: another seed is another perception, unless it is told to keep its own.
TEST_F(Cli, SeedsOfTheBackEndCanShareAPerception) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  const fs::path kept = folder() / "kept", sequence = data / "sequence";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_program({"perceive", sequence, kept, "--quiet", "--seed", "1"}).exit_code, 0);
  const std::string made = read_text(kept / "perception.yaml");
  const auto estimate = [&](std::vector<std::string> more) {
    std::vector<std::string> command = {"estimate", sequence,       out(), "--quiet",
                                        "--force",  "--perception", kept};
    command.insert(command.end(), more.begin(), more.end());
    const ProgramRun run = run_program(command);
    EXPECT_EQ(run.exit_code, 0) << run.err;
  };
  estimate({"--seed", "2", "--perception-seed", "1"});
  EXPECT_EQ(read_text(kept / "perception.yaml"), made);
  EXPECT_NE(read_text(fs::path(out()) / "run.yaml").find("\nseed: 2\nperception_seed: 1\n"),
            std::string::npos);
  estimate({"--seed", "2"});
  EXPECT_NE(read_text(kept / "perception.yaml"), made);
}

TEST_F(Cli, InfoSaysWhatAKeptPerceptionIsAndWhatIsWrongWithIt) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  const fs::path kept = folder() / "kept";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_program({"perceive", data / "sequence", kept, "--quiet"}).exit_code, 0);
  const ProgramRun whole = run_program({"info", kept, "--check"});
  EXPECT_EQ(whole.exit_code, 0) << whole.out << whole.err;
  for (const char* line : {"perception made by uniquadric", ", key ", "\nframes: 4 over 0.300 s; ",
                           "\nbody 1: in ", "\nbody 2: in ", "\n0 problems\n"})
    EXPECT_NE(whole.out.find(line), std::string::npos) << line << whole.out;
  std::string bytes = read_text(kept / "observations.bin");
  write("kept/notes.txt", "mine");
  const ProgramRun company = run_program({"info", kept, "--check"});
  EXPECT_NE(company.out.find("notes.txt: is no part of a kept perception\n1 problems"), std::string::npos)
      << company.out;
  bytes[bytes.size() / 2] ^= 1;
  write_text(kept / "observations.bin", bytes);
  EXPECT_EQ(run_program({"info", kept, "--check"}).exit_code, 2);
}

}  // namespace
}  // namespace uniquadric
