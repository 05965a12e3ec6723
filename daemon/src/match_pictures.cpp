#include "daemon/match_pictures.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "render/match_image.hpp"
#include "render/png_writer.hpp"

namespace onemap::daemon {

Status MatchPictures::frame(const hal::FrameView& frame, const mapping::FrameReport& report,
                            const mapping::LocalMapper& mapper) {
  Status status = success();
  const auto matches = mapper.last_matches();
  const auto photograph = photographs_.find(matches.keyframe_index);
  if (frame.index % static_cast<std::uint64_t>(every_) == 0 && matches.frame && matches.keyframe &&
      photograph != photographs_.end()) {
    std::error_code ignored;  // write_png says what is wrong with the folder
    std::filesystem::create_directories(folder_, ignored);
    const int width = frame.intrinsics->width, height = frame.intrinsics->height;
    const render::MatchSide left{photograph->second, width, height, *matches.keyframe};
    const render::MatchSide right{frame.rgb, width, height, *matches.frame};
    std::vector<mapping::Match> turned(matches.matches.begin(), matches.matches.end());  // keyframe on the left
    for (mapping::Match& m : turned) std::swap(m.a, m.b);
    status = render::write_png(fmt::format("{}/{:06}.png", folder_, frame.index),
                               render::draw_matches(left, right, turned, matches.kept));
  }
  if (report.keyframe_added) photographs_.try_emplace(keyframes_++, frame.rgb.begin(), frame.rgb.end());
  return status;
}

}  // namespace onemap::daemon
