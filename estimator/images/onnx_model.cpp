#include "estimator/images/onnx_model.h"

#include <fmt/format.h>

#include <mutex>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <regex>

#include "core/base/error.h"

namespace uniquadric {

struct OnnxModel::State {
  std::filesystem::path file;
  cv::dnn::Net net;
  std::mutex mutex;  // a network holds the state of its run
};

namespace {

// OpenCV prints what it then throws; one line of ours says it.
class Silence {
 public:
  ~Silence() { cv::utils::logging::setLogLevel(level_); }

 private:
  cv::utils::logging::LogLevel level_ = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
};

// What OpenCV says of a model it refuses, in one line: the layer where it names one, then its reason.
std::string reason(const cv::Exception& e) {
  std::string text = e.err.empty() ? e.what() : e.err;
  std::smatch layer;
  std::string where;
  if (std::regex_search(text, layer, std::regex(R"(\[([^\]]+)\]:\(([^)]*)\))")))
    where = fmt::format("layer {} ({}): ", layer[2].str(), layer[1].str());
  for (char& c : text)
    if (c == '\n') c = ' ';
  return where + text;
}

}  // namespace

OnnxModel::OnnxModel(const std::filesystem::path& file) : state_(std::make_shared<State>()) {
  state_->file = file;
  if (file.empty())
    throw InputError("segmentation or tracking by a network: the variant names no ONNX file for it");
  if (!std::filesystem::is_regular_file(file)) throw InputError(file, "no such ONNX file");
  const Silence silence;
  try {
    state_->net = cv::dnn::readNetFromONNX(file.string());
  } catch (const cv::Exception& e) {
    throw InputError(file, "OpenCV refuses this network: " + reason(e));
  }
  if (state_->net.empty()) throw InputError(file, "holds no network");
  state_->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  state_->net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
}

std::vector<cv::Mat> OnnxModel::run(const std::map<std::string, cv::Mat>& inputs,
                                    const std::vector<std::string>& outputs) const {
  const std::lock_guard lock(state_->mutex);
  const Silence silence;
  std::vector<cv::Mat> results;
  try {
    for (const auto& [name, blob] : inputs) state_->net.setInput(blob, name);
    state_->net.forward(results, outputs);
  } catch (const cv::Exception& e) {
    throw InputError(state_->file, "this network cannot be run as it should: " + reason(e));
  }
  for (cv::Mat& result : results) result = result.clone();  // the network writes over its own
  return results;
}

std::vector<std::string> OnnxModel::output_names() const {
  return state_->net.getUnconnectedOutLayersNames();
}

const std::filesystem::path& OnnxModel::file() const {
  return state_->file;
}

}  // namespace uniquadric
