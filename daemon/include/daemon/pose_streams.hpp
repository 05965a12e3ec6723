#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/mcap/mcap_recording.hpp"
#include "hal/base/result.hpp"

namespace onemap::daemon {

struct PoseStreamsView {
  std::uint64_t readers = 0;  // now
  std::uint64_t lines = 0;    // said, to each reader
  std::uint64_t dropped = 0;  // readers that did not read, and those that were too many
};

// The camera's pose for other programs, as lines of a TUM trajectory (`time tx ty tz qx qy qz qw`, metres), one a
// frame, on two Unix stream sockets: PATH.odom (smooth, never jumps) and PATH.map (the team's map; may jump; nothing
// while the robot is not in it). Whoever connects hears a comment that names the frame, and then what is new: for
// example `socat - UNIX:PATH.map`. Nobody is waited for: a reader that does not read is dropped, and counted. One
// thread says poses; the view is anybody's.
class PoseStreams {
 public:
  static constexpr std::size_t kReaders = 16;  // of each

  // Takes the place of sockets that nobody listens at; the error names what is in the way.
  static Result<PoseStreams> open(const std::string& path);
  PoseStreams(PoseStreams&& other) noexcept;
  PoseStreams& operator=(PoseStreams&&) = delete;
  ~PoseStreams();  // and removes them

  void say(const RecordedPose& pose);
  PoseStreamsView view() const { return {readers_, lines_, dropped_}; }

 private:
  struct Stream {
    std::string path, frame;
    int listener = -1;
    std::vector<int> readers;
  };
  PoseStreams() = default;
  static Result<int> listen_at(const std::string& path);
  void greet(Stream& stream);
  void say(Stream& stream, const std::string& line);
  void count();

  std::array<Stream, 2> streams_;  // odom, map
  std::atomic<std::uint64_t> readers_ = 0, lines_ = 0, dropped_ = 0;
};

}  // namespace onemap::daemon
