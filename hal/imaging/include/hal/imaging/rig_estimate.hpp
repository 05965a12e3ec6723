#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "hal/base/result.hpp"
#include "hal/imaging/edge_alignment.hpp"
#include "hal/imaging/plane_offset.hpp"
#include "hal/imaging/rig_calibration.hpp"

namespace onemap::hal::imaging {

// A camera's calibration from images of an ordinary room, beginning with a nominal one: where the depth lens is
// (edges), the offset of depth (planes), and depth's scale if the distance of the two lenses is known. Without it
// nothing tells the scale: a room that is twice as large, seen by lenses twice as far apart, gives the same images.
class RigEstimator {
 public:
  struct Settings {
    std::optional<double> baseline_m;  // how far the lenses are apart, measured or by the maker
  };
  struct Estimated {
    RigCalibration rig;  // the nominal one with what was told
    EdgeAlignment::Found lens;
    Estimate offset;                // metres
    bool offset_told = false;       // it is more than its deviation makes likely
    std::optional<Estimate> scale;  // depth values a metre
    std::size_t planes = 0;
  };

  // The error (a reason only): there is no depth lens.
  static Result<RigEstimator> create(const RigCalibration& nominal, const Settings& settings);
  // Images of the sizes that the calibration has: depth as its own lens sees it.
  void add(std::span<const std::uint8_t> rgb, std::span<const std::uint16_t> depth);
  // The error (a reason only) says what the images lack.
  Result<Estimated> estimate() const;

 private:
  RigEstimator(const RigCalibration& nominal, const Settings& settings);
  Status scale(Estimated& out) const;

  RigCalibration nominal_;
  Settings settings_;
  PlaneOffset planes_;
  EdgeAlignment edges_;
};

// About x, y, z; of a turn as small as a rig's.
std::array<double, 3> turn_rad(const ColourFromDepth& pose);

// For people: each number with its deviation, and what could not be told and why.
std::string words_of(const RigEstimator::Estimated& estimated);

}  // namespace onemap::hal::imaging
