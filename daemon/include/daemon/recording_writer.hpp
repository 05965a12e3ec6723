#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/depth_camera.hpp"
#include "hal/frame.hpp"

namespace onemap::daemon {

// `tx ty tz qx qy qz qw` of where the camera is at a frame, for who knows it: a simulated camera.
using TruthLine = std::function<std::optional<std::string>(const hal::FrameView&)>;
TruthLine truth_of(const std::string& camera_address);  // empty: nobody knows it

// What calibration.txt says of the camera.
struct RecordedCamera {
  hal::Intrinsics intrinsics;
  hal::DepthNoise noise;
  std::string description;  // for people
};
RecordedCamera recorded(const hal::DepthCamera& camera);

// Writes frames as the TUM layout that `replay:` plays: rgb/ and depth/ (PNG), rgb.txt and depth.txt, calibration.txt,
// and groundtruth.txt where the truth is known. Depth is 5000 values a metre, as everybody's readers of this layout
// expect: a camera's own finer steps are rounded, and what is farther than 13.1 m is no reading. Times are exact.
// A frame is in the lists when both its pictures are on their way to the disk, whole: what a killed process leaves
// plays up to its last frame. (A power cut may cost the last seconds; the lists say what was there, and replay what is
// not.) Used by one thread.
class RecordingWriter {
 public:
  static constexpr double kDepthScale = 5000;

  // Makes the folder. One that holds a recording is refused: nothing is ever written over.
  static Result<RecordingWriter> open(const std::string& folder, const RecordedCamera& camera, TruthLine truth = {});
  RecordingWriter(RecordingWriter&& other) noexcept;
  RecordingWriter& operator=(RecordingWriter&&) = delete;
  ~RecordingWriter();

  Status write(const hal::FrameView& frame);
  std::uint64_t bytes() const { return bytes_; }  // on the disk so far
  std::uint64_t frames() const { return frames_; }
  const std::string& folder() const { return folder_; }

 private:
  RecordingWriter(std::string folder, TruthLine truth) : folder_(std::move(folder)), truth_(std::move(truth)) {}
  Status begin(const RecordedCamera& camera);
  Status begin_list(int& list, const std::string& name, const std::string& head);
  Status put(const std::string& name);               // file_
  Status append(int list, const std::string& line);  // whole, or an error
  std::span<const std::uint16_t> scaled(const hal::FrameView& frame);

  std::string folder_;
  TruthLine truth_;
  int rgb_list_ = -1, depth_list_ = -1, truth_list_ = -1;
  std::vector<std::uint8_t> file_;
  std::vector<std::uint16_t> depth_;
  std::uint64_t bytes_ = 0, frames_ = 0;
};

}  // namespace onemap::daemon
