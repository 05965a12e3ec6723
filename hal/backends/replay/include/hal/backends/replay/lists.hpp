#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::hal::replay {

// Pure functions over the text files of a recording. '#' starts a comment; blank lines and CRLF are fine. A line that
// cannot be used is left out and named in `problems` with NAME:LINE.

struct ListedImage {
  FrameTime time{};
  std::string path;  // as listed
  int line = 0;      // of the list, from 1; 0 when no list named it
};

struct ImageList {
  std::vector<ListedImage> images;  // strictly increasing time
  std::vector<Error> problems;
};

struct ListedPair {
  ListedImage color, depth;
};

struct PairList {
  std::vector<ListedPair> pairs;  // strictly increasing colour time
  std::vector<Error> problems;
};

// Decimal seconds such as 1305031102.175304, exactly, to the nanosecond (further digits are cut). No sign, no exponent.
Result<FrameTime> parse_time(std::string_view text);

ImageList parse_image_list(std::string_view text, const std::string& name);  // time path
// Lines that name a path below depth/ first (as ICL-NUIM's do) are taken the other way round.
PairList parse_associations(std::string_view text, const std::string& name);  // colour time path, depth time path

// Each colour image with at most one depth image and the other way round, at most max_dt apart; the closest pairs are
// taken first, as TUM's associate.py does, earlier times first among equals. Both lists have strictly increasing times.
std::vector<ListedPair> associate(const std::vector<ListedImage>& color, const std::vector<ListedImage>& depth,
                                  Duration max_dt);

}  // namespace onemap::hal::replay
