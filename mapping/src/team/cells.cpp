#include "team/cells.hpp"

#include <algorithm>
#include <cassert>

#include "local/twin.hpp"

namespace onemap::mapping::cells {
namespace {

// Adding and taking away again leaves a double without its fraction, to nearest.
constexpr double kRounding = 6755399441055744.0;  // 1.5 * 2^52
constexpr std::int32_t kEnd = kBlockSide * kFraction;

// The part of each row where the patch is, both included, a little too long: each voxel is tested exactly later.
struct Ends {
  std::array<std::int32_t, kMostRows + kStride> first, last;
};

ONEMAP_TWIN_BODY void clip(const Rows& in, Ends& out) {
  for (int at = 0; at < in.rows; at += kStride)
    for (int row = at; row < at + kStride; ++row) {
      double t0 = 0.01, t1 = in.columns - 1.01;
      for (std::size_t i = 0; i < 3; ++i) {
        const double start = in.x[i][0] + in.y[i][row] + in.z[i] + in.offset[i];
        const double a = (in.from[i] - start) * in.steps[i], b = (in.to[i] - start) * in.steps[i];
        t0 = std::max(t0, std::min(a, b));
        t1 = std::min(t1, std::max(a, b));
      }
      const double least = std::min(t0, in.columns + 1.0) + 0.98, most = std::max(t1, -1.0) + 1.01;
      out.first[static_cast<std::size_t>(row)] = static_cast<std::int32_t>(least);
      out.last[static_cast<std::size_t>(row)] = static_cast<std::int32_t>(most) - 1;
    }
}

// A row's voxels, in memory: what is worked out for eight at a time is looked at one by one.
struct Candidates {
  std::array<std::uint32_t, kMostColumns + kStride> cell, fractions, whole, counts;
};

// Of kStride voxels, in 1/kFraction.
ONEMAP_TWIN_BODY void place(const Rows& in, int row, int first, std::int32_t (&out)[3][kStride]) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* x = in.x[axis] + first;
    const double y = in.y[axis][row], z = in.z[axis], offset = in.offset[axis], origin = in.origin[axis];
    for (std::size_t i = 0; i < kStride; ++i) {
      const double fine = (x[i] + y + z + offset) * kFraction + 0.5, near = (fine + kRounding) - kRounding;
      out[axis][i] = static_cast<std::int32_t>((near > fine ? near - 1 : near) - origin);
    }
  }
}

ONEMAP_TWIN_BODY void look(const Rows& in, const std::int32_t (&positions)[3][kStride], std::size_t at,
                           Candidates& out) {
  for (std::size_t i = 0; i < kStride; ++i) {
    const auto x = static_cast<std::uint32_t>(positions[0][i]), y = static_cast<std::uint32_t>(positions[1][i]),
               z = static_cast<std::uint32_t>(positions[2][i]);
    constexpr std::uint32_t kSteps = kBlockSide - 1, kPart = kFraction - 1;
    const std::uint32_t row = ((z >> 8) & kSteps) * kBlockSide + ((y >> 8) & kSteps);
    const std::uint32_t whole = (in.whole[row] >> ((x >> 8) & kSteps)) & 1u;
    const std::uint32_t on_face = ((x & kPart) == 0 || (y & kPart) == 0 || (z & kPart) == 0) ? 1u : 0u;
    const std::uint32_t within = (x | y | z) < kEnd ? 1u : 0u;  // what is below 0 is very large
    out.cell[at + i] = row * kBlockSide + ((x >> 8) & kSteps);
    out.fractions[at + i] = (x & kPart) | ((y & kPart) << 8) | ((z & kPart) << 16);
    out.whole[at + i] = whole;
    out.counts[at + i] = within & (whole | on_face);
  }
}

// No branch for each voxel: it is written, and counts or is written over.
ONEMAP_TWIN_BODY Place* keep(const Candidates& from, int count, const std::uint32_t* numbers, std::uint32_t number,
                             Place* out) {
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    *out = {from.cell[k], from.fractions[k], number + numbers[i], from.whole[k]};
    out += from.counts[k];
  }
  return out;
}

ONEMAP_TWIN_BODY void find_body(const Rows& in, Place*& out) {
  assert(in.rows <= kMostRows && in.columns <= kMostColumns);
  Ends ends;
  clip(in, ends);
  Candidates candidates;
  Place* next = out;
  for (int row = 0; row < in.rows; ++row) {
    const int first = ends.first[static_cast<std::size_t>(row)],
              count = ends.last[static_cast<std::size_t>(row)] - first + 1;
    for (int at = 0; at < count; at += kStride) {
      std::int32_t positions[3][kStride];
      place(in, row, first + at, positions);
      look(in, positions, static_cast<std::size_t>(at), candidates);
    }
    next = keep(candidates, count, in.number_x + first, in.number_y[row] + in.number_z, next);
  }
  out = next;
}

// From one corner to the next on an axis; the second and third time on sums of such.
std::uint32_t between(std::uint32_t a, std::uint32_t b, std::uint32_t fraction) {
  return a * kFraction + fraction * (b - a);  // modulo 2^32; at most 255 * 2^24
}

}  // namespace

ONEMAP_TWIN(find, (const Rows& rows, Place*& out), (rows, out))

void blend_plain(const Patch::Voxel* voxels, const Place* places, std::size_t count, Sample* out) {
  for (std::size_t i = 0; i < count; ++i) {
    const Place& place = places[i];
    const std::uint32_t fx = place.fraction(0), fy = place.fraction(1), fz = place.fraction(2);
    const auto along = [&](int dy, int dz, std::size_t lane) {
      const Patch::Voxel* v = voxels + Patch::index(place.at(0), place.at(1) + dy, place.at(2) + dz);
      return between(Patch::lane(v[0], lane), Patch::lane(v[1], lane), fx);
    };
    auto& sums = out[i].sums;
    for (std::size_t k = 0; k < Patch::kLanes; ++k) {
      sums[k] = between(between(along(0, 0, k), along(1, 0, k), fy), between(along(0, 1, k), along(1, 1, k), fy), fz);
      out[i].means[k] = (sums[k] + kHalf) / kOne;
    }
    out[i].tsdf = distance(sums);
  }
}

}  // namespace onemap::mapping::cells
