#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

// A map to be drawn: STEM.png, STEM.glb, STEM.ply, STEM.pcd from a saved map (daemon/saved_map.hpp).
struct MapPicture {
  std::string stem;  // path without the ending
  std::vector<std::uint8_t> map;
  bool png = true, glb = true, points = true;  // points: STEM.ply and STEM.pcd
  std::vector<std::string> views = {};         // STEM_VIEW.png of each, in place of STEM.png
};

// What one drawing may take. A software renderer is large and not ours: neither its memory nor a fault of it is the
// daemon's.
struct PictureLimits {
  // 0: no limit. (The sanitizers map terabytes that they never touch.)
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  std::uint64_t address_space_bytes = 0;
#else
  std::uint64_t address_space_bytes = std::uint64_t{8} << 30;
#endif
  Duration time = std::chrono::seconds(300);
  int niceness = 0;                 // added to this process's
  std::function<bool()> cancelled;  // true: what is being drawn is ended at once
};

// What became of a picture.
struct PictureResult {
  Status status = success();
  std::uint64_t vertices = 0;  // of the model files
  bool killed = false;         // it took too much, or its time was over
};

// Has onemap-view draw and write them, each in a process of its own, all at a time, and waits for them. Threads may
// run. Results in the order of the pictures.
std::vector<PictureResult> write_pictures(const std::vector<MapPicture>& pictures, const PictureLimits& limits = {});

}  // namespace onemap::daemon
