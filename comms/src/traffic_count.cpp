#include "traffic_count.hpp"

#include "comms/wire/frames.hpp"

namespace onemap::comms {

namespace {
constexpr std::size_t kLaneAt = wire::kFrameHeadBytes + 16;  // of a DATA frame: behind the robot

bool is_known(std::uint8_t type) { return type != 0 && name(static_cast<FrameType>(type)) != "unknown"; }
}  // namespace

void count_traffic(Traffic::Way& way, std::span<const std::uint8_t> frames, std::size_t on_wire) {
  std::size_t counted = 0;
  while (frames.size() >= wire::kFrameHeadBytes) {
    const std::uint8_t type = frames[0];
    const std::size_t size = wire::kFrameHeadBytes + frames[1] + 256u * frames[2];
    if (size > frames.size()) break;
    if (is_known(type)) {
      const bool data =
          static_cast<FrameType>(type) == FrameType::data && size > kLaneAt && frames[kLaneAt] < kLaneCount;
      (data ? way.data[frames[kLaneAt]] : way.frames[index_of(static_cast<FrameType>(type))]) += size;
      counted += size;
    }
    frames = frames.subspan(size);
  }
  way.frames[0] += on_wire - counted;
}

}  // namespace onemap::comms
