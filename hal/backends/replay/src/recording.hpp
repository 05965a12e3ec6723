#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "address.hpp"
#include "hal/backends/replay/lists.hpp"
#include "hal/frame.hpp"
#include "hal/imaging/calibration.hpp"

namespace onemap::hal::replay {

// What a folder holds, before any image is opened.
struct Recording {
  Layout layout = Layout::tum;
  bool own_depth_time = false;  // else depth is played as taken with its colour
  std::filesystem::path folder;
  std::vector<ListedPair> pairs;       // all of the recording, strictly increasing colour time
  std::string color_list, depth_list;  // the names of the files that list the images; may be empty
  std::size_t from = 0, to = 0;        // the part to play: from <= to <= pairs.size()
  std::vector<Error> problems;         // lines that could not be used
  std::uint64_t unmatched = 0;         // images without a partner in time
  Intrinsics intrinsics;               // width and height not yet known
  imaging::Calibration calibration;    // that they are from
  std::string calibration_source;      // for people
  bool max_depth_is_none = false;      // 65535 means no reading
};

// Reads the lists and the calibration that a `replay:` address names; see hal/backends/replay.hpp.
Result<Recording> open_recording(const ReplayAddress& address);

}  // namespace onemap::hal::replay
