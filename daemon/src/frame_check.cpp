#include "daemon/frame_check.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/base/splitmix.hpp"

namespace onemap::daemon {

namespace {

constexpr std::size_t kEach = 37;             // of so many pixels one is looked at: no column, no row, no Bayer tile
constexpr int kBlack = 8, kWhite = 247;       // of 255
constexpr std::size_t kMost = 98, kOf = 100;  // of the pixels that are looked at

constexpr std::array<const char*, kFrameFaults> kBegan{
    "the camera shows the same picture again and again: its frames are not used until it moves; unplug it, or look at "
    "its cable and its hub's power",
    "the camera's pictures are black: is its lens covered, or is it dark? The way is found by depth alone, where that "
    "is enough",
    "the camera's pictures are white: is there a light straight ahead, or its exposure fixed? The way is found by "
    "depth "
    "alone, where that is enough",
    "the camera has no depth: is its projector covered or off, is everything nearer or farther than it sees, or does "
    "the sun shine in?"};
constexpr std::array<const char*, kFrameFaults> kEnded{"its pictures change again", "its pictures are no more black",
                                                       "its pictures are no more white", "it has depth again"};

std::uint64_t mixed(std::uint64_t sum, std::uint64_t value) { return SplitMix(sum ^ value).next(); }

}  // namespace

std::array<bool, kFrameFaults> FrameCheck::faults_of(const hal::FrameView& frame) {
  std::size_t looked = 0, black = 0, white = 0, depths = 0;
  std::uint64_t pixels = 0;
  for (std::size_t i = 0; i < frame.depth.size(); i += kEach) {
    const std::uint8_t *rgb = &frame.rgb[3 * i], most = std::max({rgb[0], rgb[1], rgb[2]}),
                       least = std::min({rgb[0], rgb[1], rgb[2]});
    ++looked;
    black += most < kBlack ? 1 : 0;
    white += least > kWhite ? 1 : 0;
    depths += frame.depth[i] != 0 ? 1 : 0;
    pixels = mixed(pixels, (std::uint64_t{rgb[0]} << 32) | (std::uint64_t{rgb[1]} << 40) |
                               (std::uint64_t{rgb[2]} << 48) | frame.depth[i]);
  }
  const bool frozen = any_ && pixels == last_pixels_;
  any_ = true;
  last_pixels_ = pixels;
  return {frozen, kOf * black >= kMost * looked, kOf * white >= kMost * looked, depths == 0};
}

FrameCheck::Seen FrameCheck::look(const hal::FrameView& frame) {
  Seen seen;
  seen.faults = faults_of(frame);
  for (std::size_t i = 0; i < kFrameFaults; ++i) {
    Run& run = runs_[i];
    if (seen.faults[i]) {
      ++run.frames;
      if (++run.in_a_row == kPatience) seen.began += (seen.began.empty() ? "" : "; ") + std::string(kBegan[i]);
    } else {
      if (run.in_a_row >= kPatience)
        seen.ended += fmt::format("{}{}, after {} frames", seen.ended.empty() ? "" : "; ", kEnded[i], run.in_a_row);
      run.in_a_row = 0;
    }
  }
  seen.frozen = runs_[static_cast<std::size_t>(FrameFault::frozen)].in_a_row >= kPatience;
  return seen;
}

}  // namespace onemap::daemon
