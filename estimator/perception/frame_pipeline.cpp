#include "estimator/perception/frame_pipeline.h"

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include "core/base/threads.h"

namespace uniquadric {

void pass_frames_of_any(int threads, int in_flight, const std::function<std::shared_ptr<void>()>& take,
                        const std::vector<PipelineStage<void*>>& stages) {
  using Handle = std::shared_ptr<void>;
  constexpr auto kSerial = tbb::filter_mode::serial_in_order, kParallel = tbb::filter_mode::parallel;
  auto passed = tbb::make_filter<void, Handle>(kSerial, [&](tbb::flow_control& control) {
    Handle work = take();
    if (!work) control.stop();
    return work;
  });
  for (const PipelineStage<void*>& stage : stages)
    passed &= tbb::make_filter<Handle, Handle>(stage.order == FrameOrder::in_order ? kSerial : kParallel,
                                               [&stage](Handle work) {
                                                 void* frame = work.get();
                                                 stage.pass(frame);
                                                 return work;
                                               });
  const auto done = tbb::make_filter<Handle, void>(kParallel, [](const Handle&) {});
  tbb::task_arena(threads_to_use(threads)).execute([&] { tbb::parallel_pipeline(in_flight, passed & done); });
}

}  // namespace uniquadric
