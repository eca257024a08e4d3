#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace uniquadric {

/// A network from an ONNX file, run by OpenCV's dnn module. Copies share the network; runs of all copies
/// exclude one another.
class OnnxModel {
 public:
  /// Throws InputError with the file, and where OpenCV names it the layer, when it cannot take the model.
  explicit OnnxModel(const std::filesystem::path& file);

  /// The outputs of one run, in the order of `outputs`; `inputs` by name (an only input may have the name
  /// ""). Throws InputError with the file when the network does not take these inputs or lacks an output.
  std::vector<cv::Mat> run(const std::map<std::string, cv::Mat>& inputs,
                           const std::vector<std::string>& outputs) const;
  /// Names of the outputs, in the network's order.
  std::vector<std::string> output_names() const;
  const std::filesystem::path& file() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace uniquadric
