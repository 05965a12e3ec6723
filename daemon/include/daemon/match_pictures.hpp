#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/local/local_mapper.hpp"

namespace onemap::daemon {

// Pictures of feature matches on request (the paper, figure 4): every so many frames OUT/matches/NNNNNN.png. Keeps a
// copy of every keyframe's photograph, so it costs memory that a robot in service does not spend.
class MatchPictures {
 public:
  MatchPictures(std::string folder, int every) : folder_(std::move(folder)), every_(every) {}
  // After each processed frame. The error of a picture that could not be written.
  Status frame(const hal::FrameView& frame, const mapping::FrameReport& report, const mapping::LocalMapper& mapper);

 private:
  const std::string folder_;
  const int every_;
  using Photograph = std::vector<std::uint8_t>;
  std::map<FrameTime, Photograph> keyframes_;
  FrameTime last_time_{};  // of the last placed frame
  Photograph last_;
};

}  // namespace onemap::daemon
