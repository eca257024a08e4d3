#include "estimator/features/point_flow.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace uniquadric {
namespace {

std::vector<cv::Point2f> to_cv(const std::vector<Eigen::Vector2d>& points) {
  std::vector<cv::Point2f> result;
  result.reserve(points.size());
  for (const auto& p : points) result.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  return result;
}

void flow(const FlowImage& from, const FlowImage& to, const std::vector<cv::Point2f>& points,
          std::vector<cv::Point2f>& found, std::vector<unsigned char>& status, int levels,
          const PointFlowOptions& options) {
  std::vector<float> error;
  const cv::TermCriteria stop(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, options.iterations, 0.005);
  cv::calcOpticalFlowPyrLK(from.pyramid, to.pyramid, points, found, status, error,
                           cv::Size(options.window_px, options.window_px), levels, stop,
                           cv::OPTFLOW_USE_INITIAL_FLOW, options.min_eigenvalue);
}

}  // namespace

FlowImage make_flow_image(const cv::Mat& gray, const PointFlowOptions& options) {
  FlowImage image;
  cv::buildOpticalFlowPyramid(gray, image.pyramid, cv::Size(options.window_px, options.window_px),
                              options.levels);
  return image;
}

std::vector<std::optional<Eigen::Vector2d>> follow_points(const FlowImage& before, const FlowImage& now,
                                                          const std::vector<Eigen::Vector2d>& points,
                                                          const std::vector<Eigen::Vector2d>& seeds,
                                                          const PointFlowOptions& options) {
  std::vector<std::optional<Eigen::Vector2d>> result(points.size());
  if (points.empty()) return result;
  const auto start = to_cv(points);
  auto forward = to_cv(seeds);
  std::vector<unsigned char> status, status_back;
  flow(before, now, start, forward, status, options.levels, options);
  auto backward = start;
  flow(now, before, forward, backward, status_back, 0, options);
  const cv::Rect2f image(0, 0, static_cast<float>(now.pyramid[0].cols - 1),
                         static_cast<float>(now.pyramid[0].rows - 1));
  for (std::size_t i = 0; i < points.size(); ++i)
    if (status[i] && status_back[i] && image.contains(forward[i]) &&
        cv::norm(backward[i] - start[i]) <= options.max_round_trip_px)
      result[i] = Eigen::Vector2d(forward[i].x, forward[i].y);
  return result;
}

}  // namespace uniquadric
