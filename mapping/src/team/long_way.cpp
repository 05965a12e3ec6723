#include "mapping/team/long_way.hpp"

#include <utility>

namespace onemap::mapping {

namespace {

constexpr unsigned kBits = 7;  // of a byte; the eighth says that more follow
constexpr std::uint64_t kMore = 1u << kBits;

// Small numbers of either sign become small ones.
std::uint64_t zigzag64(std::uint64_t difference) { return difference << 1 ^ (0 - (difference >> 63)); }
std::uint64_t unzigzag64(std::uint64_t code) { return code >> 1 ^ (0 - (code & 1)); }

void put(std::uint64_t code, std::vector<std::uint8_t>& out) {
  for (; code >= kMore; code >>= kBits) out.push_back(static_cast<std::uint8_t>(code | kMore));
  out.push_back(static_cast<std::uint8_t>(code));
}
std::uint64_t take(const std::uint8_t*& at) {
  std::uint64_t code = 0;
  for (unsigned shift = 0;; shift += kBits) {
    const std::uint64_t byte = *at++;
    code |= (byte & (kMore - 1)) << shift;
    if (byte < kMore) return code;
  }
}

}  // namespace

void LongWay::Packed::push(const StampedPose& pose) {
  Fields now{static_cast<std::uint64_t>(pose.time.time_since_epoch().count())};
  for (std::size_t i = 0; i < 3; ++i) now[1 + i] = static_cast<std::uint64_t>(pose.T_robot_camera.t_10um[i]);
  for (std::size_t i = 0; i < 4; ++i) now[4 + i] = static_cast<std::uint64_t>(pose.T_robot_camera.q_wxyz[i]);
  for (std::size_t i = 0; i < now.size(); ++i) put(zigzag64(now[i] - (2 * last[i] - before[i])), bytes);
  before = std::exchange(last, now);
  ++size;
}

std::vector<StampedPose> LongWay::poses() const {
  std::vector<StampedPose> out(packed_.size);
  Fields last{}, before{};
  const std::uint8_t* at = packed_.bytes.data();
  for (StampedPose& pose : out) {
    Fields now{};
    for (std::size_t i = 0; i < now.size(); ++i) now[i] = unzigzag64(take(at)) + (2 * last[i] - before[i]);
    before = std::exchange(last, now);
    pose.time = frame_time_from_ns(static_cast<std::int64_t>(now[0]));
    for (std::size_t i = 0; i < 3; ++i) pose.T_robot_camera.t_10um[i] = static_cast<std::int32_t>(now[1 + i]);
    for (std::size_t i = 0; i < 4; ++i) pose.T_robot_camera.q_wxyz[i] = static_cast<std::int32_t>(now[4 + i]);
  }
  return out;
}

void LongWay::add(const StampedPose& pose) {
  if (added_++ % each_ != 0) return;
  if (packed_.size >= most_) thin();
  if ((added_ - 1) % each_ == 0) packed_.push(pose);
}

void LongWay::thin() {
  const std::vector<StampedPose> all = poses();
  packed_ = {};
  for (std::size_t i = 0; i < all.size(); i += 2) packed_.push(all[i]);
  each_ *= 2;
}

}  // namespace onemap::mapping
