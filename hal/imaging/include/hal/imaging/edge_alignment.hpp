#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/frame.hpp"
#include "hal/imaging/register_depth.hpp"

namespace onemap::hal::imaging {

// Where the depth lens is beside the colour lens, from images of both: where depth jumps, colour changes, too. Of the
// pose five numbers are told: the turn, and the place across the view. How far one lens is before the other moves no
// edge that could be seen, and stays as it was. Pure; deterministic.
class EdgeAlignment {
 public:
  // Five deviations, from stretches of time and from two starts: of the turn about x, y, z (radians) and of the place
  // in x, y (metres).
  struct Found {
    ColourFromDepth pose;
    std::array<double, 5> sigma{};
    std::size_t edges = 0;  // that lay on an edge of the colour image at the end
    double unrest_px = 0;   // of those, from it
  };

  EdgeAlignment(const Intrinsics& depth, const Intrinsics& colour) : depth_(depth), colour_(colour) {}
  void add(std::span<const std::uint8_t> rgb, std::span<const std::uint16_t> depth);  // depth: in its own lens
  // From a first guess that is right within some pixels; offset_m is added to each reading. The error says what the
  // images lack.
  Result<Found> estimate(const ColourFromDepth& guess, double offset_m) const;

 private:
  struct Edge {
    float x, y, z_m;  // of what is in front: its ray in the depth camera's frame, and its depth
    bool upright;     // depth jumps from column to column, not from row to row
  };
  struct View {
    std::vector<std::uint8_t> grey;
    std::vector<Edge> edges;
  };
  struct Match;
  struct Guess {
    ColourFromDepth pose;
    double offset_m;
  };
  void find_edges(View& view, std::span<const std::uint16_t> depth) const;
  bool match(const View& view, const Edge& edge, const Guess& guess, double reach_px, Match& out) const;
  // One step, without that group of images (-1: with all).
  bool improve(Guess& guess, double reach_px, int group, int groups, Found& found) const;

  Intrinsics depth_, colour_;
  std::vector<View> views_;
};

}  // namespace onemap::hal::imaging
