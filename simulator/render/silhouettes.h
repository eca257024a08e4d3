#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "simulator/render/render_targets.h"
#include "simulator/render/renderer.h"

namespace uniquadric {

/// Draws each object alone (`draw(i)`) and fills silhouette_px and touches_border of views[i]. Eight objects
/// share a pass: each has one bit of the stencil buffer. `bits` is reused from call to call.
void draw_silhouettes(const GlFunctions& gl, const RenderTargets& targets,
                      const std::function<void(std::size_t)>& draw, cv::Mat& bits,
                      std::vector<ObjectView>& views);

/// Fills visible_px from the drawn ids (16UC1).
void count_visible(const cv::Mat& ids, std::vector<ObjectView>& views);

}  // namespace uniquadric
