#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/local/local_mapper.hpp"
#include "mapping/local/match.hpp"
#include "mapping/local/ray_table.hpp"

namespace onemap::daemon {

// Pictures of feature matches on request (the paper, figure 4): every so many frames OUT/matches/KKKKKK-NNNNNN.png,
// frame N against the last keyframe but one, K, so that there is parallax. Keeps the photographs of two keyframes.
class MatchPictures {
 public:
  MatchPictures(std::string folder, int every) : folder_(std::move(folder)), every_(every) {}
  // After each processed frame. The error of a picture that could not be written.
  Status frame(const hal::FrameView& frame, const mapping::FrameReport& report, const mapping::LocalMapper& mapper);

 private:
  struct Photograph {
    std::uint64_t index = 0;
    std::vector<std::uint8_t> rgb;
    mapping::FeatureSet features;
  };
  Status draw(const hal::FrameView& frame, const mapping::FeatureSet& features);
  std::vector<std::uint8_t> agreeing(const mapping::FeatureSet& a, const mapping::FeatureSet& b,
                                     std::span<const mapping::Match> matches);

  const std::string folder_;
  const int every_;
  std::deque<Photograph> keyframes_;  // the last two
  std::unique_ptr<mapping::RayTable> rays_;
};

}  // namespace onemap::daemon
