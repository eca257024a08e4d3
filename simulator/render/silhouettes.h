#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "simulator/render/lens.h"
#include "simulator/render/render_targets.h"
#include "simulator/render/renderer.h"

namespace uniquadric {

/// Makes every pixel that is drawn from here on, hidden or not, set the bits of the stencil mask in a stencil
/// that is zero at first. So the pass that draws the image yields the silhouettes too.
void begin_silhouettes(const GlFunctions& gl);

/// The stencil mask of an object (from 0) in that pass: a bit of its own for each of the first eight, none
/// beyond.
unsigned silhouette_bit(std::size_t object);

/// Fills silhouette_px and touches_border from the image's stencil; objects beyond the first eight are drawn
/// again (`draw(i)`), eight a pass. `part` of the image holds all silhouettes: reading costs more than
/// counting. With a `lens` (or null) the pixels of its camera are counted, of which `part` holds what is
/// drawn. `bits` is reused from call to call.
void view_silhouettes(const GlFunctions& gl, const RenderTargets& targets, const cv::Rect& part,
                      const std::function<void(std::size_t)>& draw, const Lens* lens, cv::Mat& bits,
                      std::vector<ObjectView>& views);

/// Fills visible_px from the drawn ids (16UC1).
void count_visible(const cv::Mat& ids, std::vector<ObjectView>& views);

}  // namespace uniquadric
