#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/result.hpp"

namespace onemap::mapping {

struct FinishedRecord {  // lane control: this robot will write nothing more of its own camera
  std::uint32_t frames = 0, tracked = 0, keyframes = 0, submaps = 0;
};

std::vector<std::uint8_t> encode(const FinishedRecord& record);
Result<FinishedRecord> decode_finished(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
