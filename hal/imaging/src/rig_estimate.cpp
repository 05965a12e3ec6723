#include "hal/imaging/rig_estimate.hpp"

#include <fmt/format.h>

#include <cmath>

namespace onemap::hal::imaging {

namespace {

constexpr double kSigmas = 3;              // an offset within so many deviations of 0 is none
constexpr double kMostDeviation_m = 0.01;  // deviation: more is no calibration
constexpr double kMostScale = 0.05;        // deviation, as a share
constexpr double kMostBaseline_m = 0.5;    // of two lenses on one body

}  // namespace

Result<RigEstimator> RigEstimator::create(const RigCalibration& nominal, const Settings& settings) {
  if (!nominal.depth) return Error{"", "it has no lens for depth, so that there is nothing to estimate"};
  if (settings.baseline_m && !(*settings.baseline_m > 0 && *settings.baseline_m <= kMostBaseline_m))
    return Error{"", fmt::format("a baseline is above 0 and at most {} m", kMostBaseline_m)};
  return RigEstimator(nominal, settings);
}

RigEstimator::RigEstimator(const RigCalibration& nominal, const Settings& settings)
    : nominal_(nominal),
      settings_(settings),
      planes_(*nominal.depth, nominal.noise),
      edges_(*nominal.depth, nominal.colour) {}

void RigEstimator::add(std::span<const std::uint8_t> rgb, std::span<const std::uint16_t> depth) {
  planes_.add(depth);
  edges_.add(rgb, depth);
}

Result<RigEstimator::Estimated> RigEstimator::estimate() const {
  Estimated out;
  out.rig = nominal_;
  out.planes = planes_.planes();
  out.offset = planes_.estimate();
  out.offset_told = out.offset.sigma < kMostDeviation_m && std::abs(out.offset.value) > kSigmas * out.offset.sigma;
  if (out.offset_told) out.rig.depth_offset_m = out.offset.value;
  const auto lens = edges_.estimate(nominal_.pose, out.rig.depth_offset_m);
  if (!lens) return lens.error();
  out.lens = *lens;
  out.rig.pose = lens->pose;
  if (settings_.baseline_m)
    if (const Status status = scale(out); !status) return status.error();
  return out;
}

// Edges tell the lenses' distance in the units of depth: if it is another one in truth, so is every depth.
Status RigEstimator::scale(Estimated& out) const {
  auto& t = out.rig.pose.translation_m;
  const double found_m = std::hypot(t[0], t[1], t[2]),
               sigma_m = std::hypot(t[0] * out.lens.sigma[3], t[1] * out.lens.sigma[4]) / found_m;
  const double share = *settings_.baseline_m / found_m, sigma = sigma_m / found_m;
  if (!(sigma <= kMostScale))
    return Error{"", fmt::format("the lenses' distance is {:.1f} mm, give or take {:.1f}: too unsure to tell the scale "
                                 "of depth by it",
                                 1000 * found_m, 1000 * sigma_m)};
  for (double& part : t) part *= share;
  out.rig.depth_offset_m *= share;
  for (Intrinsics* k : {&out.rig.colour, &*out.rig.depth}) k->depth_scale /= share;
  out.scale = Estimate{out.rig.colour.depth_scale, out.rig.colour.depth_scale * sigma};
  return success();
}

std::array<double, 3> turn_rad(const ColourFromDepth& pose) {
  const auto& r = pose.rotation;
  return {(r[7] - r[5]) / 2, (r[2] - r[6]) / 2, (r[3] - r[1]) / 2};
}

std::string words_of(const RigEstimator::Estimated& e) {
  const auto& t = e.rig.pose.translation_m;
  constexpr double kDegrees = 180 / M_PI;
  const auto turn = turn_rad(e.rig.pose);
  std::string out =
      fmt::format("{} edges, {:.2f} px from colour's; {} planes\n", e.lens.edges, e.lens.unrest_px, e.planes);
  for (std::size_t i = 0; i < 3; ++i)
    out += fmt::format("turn about {}     {:8.3f} +- {:.3f} degrees\n", "xyz"[i], turn[i] * kDegrees,
                       e.lens.sigma[i] * kDegrees);
  for (std::size_t i = 0; i < 2; ++i)
    out += fmt::format("place along {}    {:8.2f} +- {:.2f} mm\n", "xy"[i], 1000 * t[i], 1000 * e.lens.sigma[3 + i]);
  out += fmt::format("place along z    {:8.2f} mm, as it was: no edge tells it\n", 1000 * t[2]);
  if (e.offset_told)
    out += fmt::format("depth's offset   {:8.2f} +- {:.2f} mm\n", 1000 * e.offset.value, 1000 * e.offset.sigma);
  else if (std::isfinite(e.offset.sigma))
    out += fmt::format("depth's offset   {:8.2f} mm, as it was: planes say {:.2f} +- {:.2f} mm\n",
                       1000 * e.rig.depth_offset_m, 1000 * e.offset.value, 1000 * e.offset.sigma);
  else
    out += fmt::format("depth's offset   {:8.2f} mm, as it was: no planes from near to far were seen\n",
                       1000 * e.rig.depth_offset_m);
  out += e.scale
             ? fmt::format("depth_scale      {:8.1f} +- {:.1f}\n", e.scale->value, e.scale->sigma)
             : fmt::format(
                   "depth_scale      {:8.1f}, as it was: a larger room gives the same images; --baseline tells it\n",
                   e.rig.colour.depth_scale);
  return out;
}

}  // namespace onemap::hal::imaging
