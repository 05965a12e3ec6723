#pragma once
#include <cstdint>
#include <string_view>

namespace onemap::mapping {

// The steps of a frame, in order; for timing by whoever owns a clock.
enum class Step : std::uint8_t {
  gray,
  features,
  cloud,
  match,
  fundamental,
  ransac,
  icp,
  refine,
  keyframe,
  integrate,
  count
};
inline constexpr std::size_t kSteps = static_cast<std::size_t>(Step::count);
std::string_view to_string(Step step);

// Called when a step begins, and with Step::count when the frame is done.
struct StepHook {
  void (*begin)(void* context, Step step) = nullptr;
  void* context = nullptr;

  void operator()(Step step) const {
    if (begin != nullptr) begin(context, step);
  }
};

}  // namespace onemap::mapping
