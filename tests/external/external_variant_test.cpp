#include "harness/external/external_variant.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

class ExternalVariantFile : public testing::Test {
 protected:
  void SetUp() override { write_text(folder() / "slam.py", "print()\n"); }
  const fs::path& folder() const { return temp_.path(); }
  ExternalVariant load(const std::string& text) const {
    write_text(folder() / "mine.yaml", text);
    return load_external_variant(folder() / "mine.yaml");
  }
  std::string fault(const std::string& text) const {
    return input_error([&] { load(text); }).substr(folder().string().size());
  }

  TempFolder temp_;
  const std::string command_ = "command: [python3, slam.py, \"{sequence}\", \"{out}\"]\n";
};

TEST_F(ExternalVariantFile, ReadsAllItsKeys) {
  const ExternalVariant v =
      load("schema: 1\nname: my_slam\n" + command_ +
           "layout: tum\nresult: kitti-tracking\ninputs: [slam.py]\nmounts: [/usr]\nenvironment: {N: \"2\"}\n"
           "limits: {time_s: 60, memory_mb: 800, output_mb: 20}\nsensors: [rgb, lidar]\noutput: final\ngpu: "
           "true\n");
  EXPECT_EQ(v.name, "my_slam");
  EXPECT_EQ(v.command, (std::vector<std::string>{"python3", "slam.py", "{sequence}", "{out}"}));
  EXPECT_EQ(v.layout, "tum");
  EXPECT_EQ(v.result, "kitti-tracking");
  EXPECT_EQ(v.inputs, std::vector<fs::path>{fs::canonical(folder()) / "slam.py"});
  EXPECT_EQ(v.mounts, std::vector<fs::path>{"/usr"});
  EXPECT_EQ(v.environment.at(0), std::pair(std::string("N"), std::string("2")));
  EXPECT_EQ(v.time_limit_s, 60);
  EXPECT_EQ(v.memory_limit_mb, 800);
  EXPECT_EQ(v.output_limit_mb, 20);
  EXPECT_EQ(v.sensors, (std::vector<std::string>{"rgb", "lidar"}));
  EXPECT_EQ(v.output, "final");
  EXPECT_TRUE(v.gpu);
}

// A file that the command names is an input, named or not; what changes in it changes the cell's key.
TEST_F(ExternalVariantFile, ItsKeyIsOfTheBytesOfItsInputs) {
  const std::string before = external_yaml(load(command_));
  EXPECT_EQ(external_yaml(load(command_)), before);
  write_text(folder() / "slam.py", "print(1)\n");
  EXPECT_NE(external_yaml(load(command_)), before);
}

TEST_F(ExternalVariantFile, BadKeysAreRefusedByTheirLine) {
  EXPECT_EQ(fault("command: []\n"), "/mine.yaml:1: command: expected a program and its arguments");
  EXPECT_EQ(fault("command: [a, \"{out}\"]\n"),
            "/mine.yaml:1: command: has no {sequence} in it: the program could not know of it");
  EXPECT_EQ(fault("command: [a, \"{sequence}\"]\n"),
            "/mine.yaml:1: command: has no {out} in it: the program could not know of it");
  EXPECT_EQ(fault(command_ + "layout: pcap\n").find("/mine.yaml:2: layout: "), 0u);
  EXPECT_EQ(fault(command_ + "sensors: [radar]\n").find("/mine.yaml:2: sensors[0]: expected one of rgb, "),
            0u);
  EXPECT_EQ(fault(command_ + "limits: {time_s: 0}\n").find("/mine.yaml:2: limits.time_s: "), 0u);
  EXPECT_NE(fault(command_ + "inputs: [none.bin]\n").find("none.bin does not exist"), std::string::npos);
  EXPECT_NE(fault(command_ + "ego: {source: rgbd}\n").find("ego"), std::string::npos);
}

TEST_F(ExternalVariantFile, IsKnownByItsCommand) {
  load(command_);
  EXPECT_TRUE(is_external(folder() / "mine.yaml"));
  EXPECT_FALSE(is_external(fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/superquadric.yaml"));
}

}  // namespace
}  // namespace uniquadric
