#pragma once
#include <array>
#include <memory>
#include <mutex>

#include "daemon/latency.hpp"
#include "mapping/local/step.hpp"

namespace onemap::daemon {

// What frames cost the work thread, as far as it has come.
struct Cost {
  Quantiles quantiles;
  double total_ms = 0;
  std::uint64_t count = 0;  // frames that took this step
};
struct FrameCosts {
  Cost frame;
  std::array<Cost, mapping::kSteps> steps;
};

// Processor time of frames by step. The work thread adds, anybody looks; adding does not allocate.
class StepTimes {
 public:
  StepTimes();
  void begin(mapping::Step step, Duration now);  // Step::count: the frame is done with its steps
  void end_frame(Duration whole);
  FrameCosts costs() const;
  const LatencyHistogram& frames() const { return histograms_->frame; }  // when nobody adds any more

 private:
  struct Histograms {
    LatencyHistogram frame;
    std::array<LatencyHistogram, mapping::kSteps> steps;
  };
  std::array<Duration, mapping::kSteps> now_{};  // of this frame
  std::array<bool, mapping::kSteps> taken_{};
  std::size_t step_ = mapping::kSteps;
  Duration began_{};
  mutable std::mutex mutex_;  // of what follows
  std::unique_ptr<Histograms> histograms_;
};

}  // namespace onemap::daemon
