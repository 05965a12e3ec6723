#include "daemon/match_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "mapping/local/fundamental.hpp"
#include "render/match_image.hpp"
#include "render/png_writer.hpp"

namespace onemap::daemon {

Status MatchPictures::frame(const hal::FrameView& frame, const mapping::FrameReport& report,
                            const mapping::LocalMapper& mapper) {
  const auto matches = mapper.last_matches();
  if (!matches.frame) return success();
  Status status = success();
  if (frame.index % static_cast<std::uint64_t>(every_) == 0 && !keyframes_.empty())
    status = draw(frame, *matches.frame);
  if (report.keyframe_added) {
    keyframes_.push_back({frame.index, {frame.rgb.begin(), frame.rgb.end()}, *matches.frame});
    if (keyframes_.size() > 2) keyframes_.pop_front();
  }
  return status;
}

Status MatchPictures::draw(const hal::FrameView& frame, const mapping::FeatureSet& features) {
  std::error_code ignored;  // write_png says what is wrong with the folder
  std::filesystem::create_directories(folder_, ignored);
  const int width = frame.intrinsics->width, height = frame.intrinsics->height;
  if (!rays_) rays_ = std::make_unique<mapping::RayTable>(*frame.intrinsics);
  const Photograph& keyframe = keyframes_.front();
  mapping::Matcher matcher({}, std::max(features.size(), keyframe.features.size()));
  const auto matches = matcher.match(keyframe.features, features);
  const std::vector<std::uint8_t> kept = agreeing(keyframe.features, features, matches);
  const render::MatchSide left{keyframe.rgb, width, height, keyframe.features, keyframe.index};
  const render::MatchSide right{frame.rgb, width, height, features, frame.index};
  return render::write_png(fmt::format("{}/{:06}-{:06}.png", folder_, keyframe.index, frame.index),
                           render::draw_matches(left, right, matches, kept), Durable::no);
}

// Which matches obey one fundamental matrix (eq. 6); none when there is no such matrix.
std::vector<std::uint8_t> MatchPictures::agreeing(const mapping::FeatureSet& a, const mapping::FeatureSet& b,
                                                  std::span<const mapping::Match> matches) {
  const auto ray = [&](const mapping::Keypoint& k) {
    const float* at = rays_->row(static_cast<int>(std::lround(k.y_px))) + 2 * std::lround(k.x_px);
    return Eigen::Vector2d(static_cast<double>(at[0]), static_cast<double>(at[1]));
  };
  std::vector<Eigen::Vector2d> r, s;
  for (const mapping::Match& m : matches) {
    r.push_back(ray(a.keypoints[m.a]));
    s.push_back(ray(b.keypoints[m.b]));
  }
  std::vector<std::uint8_t> kept(matches.size(), 0);
  mapping::Matrix3d F;
  mapping::FundamentalRansac ransac({}, matches.size());
  if (!ransac.estimate(r, s, kept, F).ok()) std::fill(kept.begin(), kept.end(), std::uint8_t{0});
  return kept;
}

}  // namespace onemap::daemon
