#include "daemon/step_times.hpp"

namespace onemap::daemon {

namespace {
Cost cost_of(const LatencyHistogram& histogram) {
  return {histogram.quantiles(), histogram.total_ms(), histogram.count()};
}
}  // namespace

StepTimes::StepTimes() : histograms_(std::make_unique<Histograms>()) {}

void StepTimes::begin(mapping::Step step, Duration now) {
  if (step_ < mapping::kSteps) {
    now_[step_] += now - began_;
    taken_[step_] = true;
  }
  step_ = static_cast<std::size_t>(step);
  began_ = now;
}

void StepTimes::end_frame(Duration whole) {
  {
    const std::lock_guard lock(mutex_);
    histograms_->frame.add(whole);
    for (std::size_t i = 0; i < mapping::kSteps; ++i)
      if (taken_[i]) histograms_->steps[i].add(now_[i]);
  }
  now_ = {};
  taken_ = {};
}

FrameCosts StepTimes::costs() const {
  const std::lock_guard lock(mutex_);
  FrameCosts costs;
  costs.frame = cost_of(histograms_->frame);
  for (std::size_t i = 0; i < mapping::kSteps; ++i) costs.steps[i] = cost_of(histograms_->steps[i]);
  return costs;
}

}  // namespace onemap::daemon
