#pragma once

#include <functional>
#include <memory>
#include <vector>

namespace uniquadric {

inline constexpr int kFramesInFlight = 4;  ///< ours: more cost memory and gain nothing on two cores

/// How a stage of a pipeline passes frames: one after the other in their order, or several at once.
enum class FrameOrder { in_order, at_once };

/// `Work`: a frame with what the stages before have made of it.
template <typename Work>
struct PipelineStage {
  FrameOrder order = FrameOrder::in_order;
  std::function<void(Work&)> pass;
};

/// Passes all that `take` makes (null: no more) through the stages, on `threads` threads (0: as many as there
/// are cores), at most `in_flight` at a time. Throws what a stage throws.
void pass_frames_of_any(int threads, int in_flight, const std::function<std::shared_ptr<void>()>& take,
                        const std::vector<PipelineStage<void*>>& stages);

/// The same of frames with a type.
template <typename Work>
void pass_frames(int threads, int in_flight, const std::function<std::shared_ptr<Work>()>& take,
                 const std::vector<PipelineStage<Work>>& stages) {
  std::vector<PipelineStage<void*>> of_any;
  for (const PipelineStage<Work>& stage : stages)
    of_any.push_back({stage.order, [&stage](void*& work) { stage.pass(*static_cast<Work*>(work)); }});
  pass_frames_of_any(threads, in_flight, take, of_any);
}

}  // namespace uniquadric
