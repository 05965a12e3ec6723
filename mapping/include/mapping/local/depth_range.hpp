#pragma once

namespace onemap::mapping {

// The depths that count as a measurement (the paper, section 3).
inline constexpr float kMinDepth_m = 0.05f;
inline constexpr float kMaxDepth_m = 8.0f;

}  // namespace onemap::mapping
