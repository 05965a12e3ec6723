// The AVX2 twin: eight voxels, a row, at a time.
#include <bit>
#include <cstring>

#include "local/fuse_block.hpp"
#include "local/voxel_bytes.hpp"
#include "mapping/local/block_key.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace onemap::mapping::fusing {

#if defined(__x86_64__)
namespace {

static_assert(kVoxelsAreBytes && kBlockSide == 8);

[[gnu::target("avx2")]] inline __m256 everywhere(float value) { return _mm256_set1_ps(value); }

// What is the same for every row.
struct Constants {
  __m256 step_x, step_y, step_z;  // from the first voxel of a row to each
  __m256 fx, fy, cx, cy, right, bottom, width;
  __m256 truncation, to_units, color_band;
};

[[gnu::target("avx2")]] inline Constants constants(const FrameOnMap& frame) {
  const __m256 n = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
  return {_mm256_mul_ps(n, everywhere(frame.step_x[0])),
          _mm256_mul_ps(n, everywhere(frame.step_x[1])),
          _mm256_mul_ps(n, everywhere(frame.step_x[2])),
          everywhere(frame.fx),
          everywhere(frame.fy),
          everywhere(frame.cx),
          everywhere(frame.cy),
          everywhere(frame.right),
          everywhere(frame.bottom),
          everywhere(frame.width),
          everywhere(frame.truncation_m),
          everywhere(static_cast<float>(kTsdfOne) / frame.truncation_m),
          everywhere(frame.color_band_m)};
}

// A row of voxels and what its pixels say.
struct Eight {
  __m256 depth, sdf;
  __m256i pixel;
  __m256 in_band;
};

[[gnu::target("avx2")]] inline __m256 whole_pixel(__m256 at, __m256 most) {
  const __m256 within = _mm256_min_ps(_mm256_max_ps(at, _mm256_setzero_ps()), most);
  return _mm256_cvtepi32_ps(_mm256_cvttps_epi32(within));
}

[[gnu::target("avx2")]] inline Eight look(const FrameOnMap& frame, const Constants& k, float x, float y, float z) {
  const __m256 z_m = _mm256_add_ps(everywhere(z), k.step_z);
  const __m256 before = _mm256_cmp_ps(z_m, everywhere(kNearest_m), _CMP_GT_OQ);
  const __m256 Z = _mm256_blendv_ps(everywhere(kBehind_m), z_m, before);
  const __m256 inv = _mm256_div_ps(everywhere(1), Z);
  const __m256 x_m = _mm256_add_ps(everywhere(x), k.step_x), y_m = _mm256_add_ps(everywhere(y), k.step_y);
  const __m256 u = whole_pixel(_mm256_add_ps(_mm256_mul_ps(_mm256_mul_ps(x_m, inv), k.fx), k.cx), k.right);
  const __m256 v = whole_pixel(_mm256_add_ps(_mm256_mul_ps(_mm256_mul_ps(y_m, inv), k.fy), k.cy), k.bottom);
  Eight row;
  row.pixel = _mm256_cvttps_epi32(_mm256_add_ps(_mm256_mul_ps(v, k.width), u));
  row.depth = _mm256_i32gather_ps(frame.depth_m, row.pixel, 4);
  row.sdf = _mm256_sub_ps(row.depth, Z);
  const __m256 seen = _mm256_cmp_ps(row.depth, _mm256_setzero_ps(), _CMP_GT_OQ);
  const __m256 behind = _mm256_sub_ps(_mm256_setzero_ps(), k.truncation);
  row.in_band = _mm256_and_ps(seen, _mm256_and_ps(_mm256_cmp_ps(row.sdf, k.truncation, _CMP_LE_OQ),
                                                  _mm256_cmp_ps(row.sdf, behind, _CMP_GE_OQ)));
  return row;
}

[[gnu::target("avx2")]] inline void put(std::int32_t* to, __m256i values) {
  _mm256_store_si256(reinterpret_cast<__m256i*>(to), values);
}

// What is added to a row: the distances times weight, weights and colours, an element a voxel.
struct Added {
  alignas(32) std::int32_t tsdf[kBlockSide];
  alignas(32) std::int32_t weight[kBlockSide];
  alignas(32) std::int32_t source[kBlockSide];
  unsigned seen, colored;
};

[[gnu::target("avx2")]] inline void measure(const FrameOnMap& frame, const Constants& k, const Eight& row, Added& out) {
  const __m256 units = _mm256_mul_ps(row.sdf, k.to_units);
  const __m256i raised = _mm256_cvttps_epi32(_mm256_add_ps(units, everywhere(static_cast<float>(kTsdfOne) + 0.5f)));
  const __m256 most = everywhere(static_cast<float>(kMostWeight)), least = everywhere(static_cast<float>(kLeastWeight));
  const __m256 information = _mm256_div_ps(most, _mm256_mul_ps(row.depth, row.depth));
  put(out.tsdf, _mm256_sub_epi32(raised, _mm256_set1_epi32(kTsdfOne)));
  put(out.weight, _mm256_cvttps_epi32(_mm256_min_ps(_mm256_max_ps(information, least), most)));
  if (frame.rgb == nullptr) {
    out.colored = 0;
    return;
  }
  const __m256 minus_band = _mm256_sub_ps(_mm256_setzero_ps(), k.color_band);
  const __m256 colored =
      _mm256_and_ps(_mm256_cmp_ps(row.sdf, k.color_band, _CMP_LE_OQ), _mm256_cmp_ps(row.sdf, minus_band, _CMP_GE_OQ));
  out.colored = out.seen & static_cast<unsigned>(_mm256_movemask_ps(colored));
  put(out.source, _mm256_i32gather_epi32(frame.source, row.pixel, 4));
}

// Sum and colour's weight; weight and colours: a voxel's 12 bytes, so that what is added is two additions.
inline void add(const FrameOnMap& frame, const Added& added, unsigned i, Voxel& voxel) {
  constexpr std::uint32_t kSum = 0xFFFFFFu, kFullColor = std::uint32_t{Voxel::kMaxColorWeight} << 24;
  const bool colored = (added.colored >> i & 1u) != 0;
  const std::uint8_t* color = colored ? frame.rgb + 3 * static_cast<std::ptrdiff_t>(added.source[i]) : nullptr;
  if (voxel.would_saturate(added.weight[i]) || (colored && voxel.color_would_saturate())) {
    voxel.add_tsdf(added.tsdf[i], added.weight[i]);
    if (colored) voxel.add_color(color[0], color[1], color[2]);
    return;
  }
  auto* bytes = reinterpret_cast<std::uint8_t*>(&voxel);
  std::uint32_t sum = 0;
  std::uint64_t rest = 0;
  std::memcpy(&sum, bytes, sizeof sum);
  std::memcpy(&rest, bytes + sizeof sum, sizeof rest);
  const auto more = static_cast<std::uint32_t>(added.tsdf[i] * added.weight[i]);
  sum = (sum & ~kSum) | ((sum + more) & kSum);
  rest += static_cast<std::uint32_t>(added.weight[i]);
  if (colored) {
    sum += 1u << 24;
    rest += std::uint64_t{color[0]} << 16 | std::uint64_t{color[1]} << 32 | std::uint64_t{color[2]} << 48;
  }
  static_assert(kFullColor == ~kSum);
  std::memcpy(bytes, &sum, sizeof sum);
  std::memcpy(bytes + sizeof sum, &rest, sizeof rest);
}

}  // namespace

[[gnu::target("avx2")]] bool fuse_block_simd(const FrameOnMap& frame, const Vector3f& first, Voxel* voxels) {
  const Constants k = constants(frame);
  Added added;
  bool changed = false;
  for (int z = 0; z < kBlockSide; ++z)
    for (int y = 0; y < kBlockSide; ++y, voxels += kBlockSide) {
      const Vector3f p = first + frame.step_y * static_cast<float>(y) + frame.step_z * static_cast<float>(z);
      const Eight row = look(frame, k, p[0], p[1], p[2]);
      added.seen = static_cast<unsigned>(_mm256_movemask_ps(row.in_band));
      if (added.seen == 0) continue;
      measure(frame, k, row, added);
      for (unsigned left = added.seen; left != 0; left &= left - 1) {
        const auto i = static_cast<unsigned>(std::countr_zero(left));
        add(frame, added, i, voxels[i]);
      }
      changed = true;
    }
  return changed;
}

#else

bool fuse_block_simd(const FrameOnMap& frame, const Vector3f& first, Voxel* voxels) {
  return fuse_block_plain(frame, first, voxels);
}

#endif

}  // namespace onemap::mapping::fusing
