#include "hal/backends/replay.hpp"

#include "recording.hpp"
#include "replay_camera.hpp"

namespace onemap::hal {

Result<std::unique_ptr<DepthCamera>> open_replay(const CameraAddress& address) {
  const Result<replay::ReplayAddress> parsed = replay::parse_replay_address(address);
  if (!parsed) return parsed.error();
  Result<replay::Recording> recording = replay::open_recording(*parsed);
  if (!recording) return recording.error();
  return replay::ReplayCamera::open(std::move(*recording));
}

Status check_replay(const CameraAddress& address) {
  const Result<replay::ReplayAddress> parsed = replay::parse_replay_address(address);
  return parsed ? success() : parsed.error();
}

}  // namespace onemap::hal
