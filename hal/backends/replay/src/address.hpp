#pragma once
#include <optional>
#include <string>
#include <utility>

#include "hal/backends.hpp"
#include "hal/base/time.hpp"
#include "hal/imaging/calibration.hpp"

namespace onemap::hal::replay {

enum class Layout { tum, seven_scenes };

// What a `replay:` address asks for.
struct ReplayAddress {
  std::string text, folder;
  std::optional<std::pair<std::size_t, std::size_t>> range;  // FROM, TO
  imaging::Calibration calibration;                          // from options
  Duration max_dt = std::chrono::milliseconds(20);
  std::optional<Layout> layout;
  std::optional<bool> own_depth_time;
};

Result<ReplayAddress> parse_replay_address(const CameraAddress& address);

// Decimal digits and nothing else.
std::optional<std::size_t> parse_count(std::string_view text);

}  // namespace onemap::hal::replay
