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
  const auto keyframe = keyframes_.find(matches.other_time);
  const Photograph* other = matches.other_time == last_time_ ? &last_
                            : keyframe != keyframes_.end()   ? &keyframe->second
                                                             : nullptr;
  if (frame.index % static_cast<std::uint64_t>(every_) == 0 && matches.frame && other && !other->empty()) {
    std::error_code ignored;  // write_png says what is wrong with the folder
    std::filesystem::create_directories(folder_, ignored);
    const int width = frame.intrinsics->width, height = frame.intrinsics->height;
    const render::MatchSide left{*other, width, height, *matches.other};
    const render::MatchSide right{frame.rgb, width, height, *matches.frame};
    std::vector<mapping::Match> turned(matches.matches.begin(),
                                       matches.matches.end());  // the earlier image on the left
    for (mapping::Match& m : turned) std::swap(m.a, m.b);
    status = render::write_png(fmt::format("{}/{:06}.png", folder_, frame.index),
                               render::draw_matches(left, right, turned, matches.kept), render::Durable::no);
  }
  if (report.state == mapping::TrackState::tracking) {
    last_time_ = frame.colour_time;
    last_.assign(frame.rgb.begin(), frame.rgb.end());
  }
  if (report.keyframe_added) keyframes_.try_emplace(frame.colour_time, last_);
  return status;
}

}  // namespace onemap::daemon
