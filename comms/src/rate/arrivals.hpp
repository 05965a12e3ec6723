#pragma once
#include <cstdint>

#include "comms/wire/frames.hpp"
#include "hal/base/time.hpp"

namespace onemap::comms {

// What came from one peer, to be told to it while it sends data, and how fast data comes.
class Arrivals {
 public:
  void came(Instant now, std::uint64_t counter, std::uint32_t data_frames, std::size_t bytes);
  bool due(Instant now) const { return unsaid_ > 0 && due_ <= now; }
  bool worth_saying(Instant now) const;  // with another frame that goes anyway
  Instant next() const { return unsaid_ > 0 ? due_ : Instant::max(); }
  wire::Feedback report(Instant now);
  double bytes_per_second() const { return rate_; }  // of data, while it comes

 private:
  void measure(Instant now, std::size_t bytes);
  std::uint64_t highest_ = 0;
  std::uint32_t received_ = 0;  // goes round
  Instant highest_at_{};
  std::uint32_t unsaid_ = 0;  // data frames since the last report
  Instant due_{}, said_{};
  double rate_ = 0.0;
  Instant measured_{};
  std::size_t bytes_ = 0;  // since then
};

}  // namespace onemap::comms
