#pragma once
// One side of a transfer over an emulated link, for the network benchmark. The sender always has bulk to send, and a
// pose of 120 bytes every 33 ms or as is said; the receiver says in one line of JSON what came.
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace onemap::bench {

using Clock = std::chrono::steady_clock;
inline constexpr std::size_t kPoseBytes = 120, kBulkBytes = 60'000;

struct Job {
  bool sends = false;
  std::string here, there;  // IPv4 addresses
  double seconds = 8;       // of measuring, from the first bulk bytes that come
  std::string flavour;      // of TCP: cubic, bbr
  bool poses = true;
  std::chrono::milliseconds pose_every{33};
};

inline std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
}

// A pose says when it was made; both sides run on one machine, so their clocks are one.
inline std::vector<std::uint8_t> pose_now() {
  std::vector<std::uint8_t> pose(kPoseBytes);
  const std::int64_t now = now_ns();
  std::memcpy(pose.data(), &now, sizeof now);
  return pose;
}

// When poses are due on the sender's side.
class PoseClock {
 public:
  explicit PoseClock(const Job& job) : every_(job.pose_every) {}
  bool due() {
    if (Clock::now() < next_) return false;
    next_ = std::max(next_ + every_, Clock::now());
    return true;
  }
  Clock::time_point next() const { return next_; }

 private:
  std::chrono::milliseconds every_;
  Clock::time_point next_ = Clock::now() + std::chrono::milliseconds(500);
};

// What the receiver counts.
class Tally {
 public:
  explicit Tally(double seconds) : seconds_(seconds) {}
  void bulk(std::size_t bytes) {
    if (bytes > 0 && !began_) began_ = Clock::now();
    bytes_ += bytes;
  }
  void pose(std::span<const std::uint8_t> body) {
    if (body.size() < sizeof(std::int64_t)) return;
    std::int64_t made = 0;
    std::memcpy(&made, body.data(), sizeof made);
    latencies_ms_.push_back(static_cast<double>(now_ns() - made) * 1e-6);
  }
  // The time is over, or nothing came for so long that nothing will.
  bool over() const {
    const auto since = Clock::now() - began_.value_or(started_);
    return since >= std::chrono::duration<double>(began_ ? seconds_ : 20.0);
  }
  void print(double duplicates) const;

 private:
  double seconds_;
  std::optional<Clock::time_point> began_;
  Clock::time_point started_ = Clock::now();
  std::uint64_t bytes_ = 0;
  std::vector<double> latencies_ms_;
};

// Each runs until it is killed (a sender) or the time is over (a receiver); 0: it went well.
int run_onemap(const Job& job);
int run_tcp(const Job& job);
int run_enet(const Job& job);
int run_norm(const Job& job);

}  // namespace onemap::bench
