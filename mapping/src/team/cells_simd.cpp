// The AVX2 twins whose sources differ from the plain ones.
#include "team/cells.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace onemap::mapping::cells {

#if defined(__x86_64__)
namespace {

template <class T>
const __m128i* vector_at(const T* at) {
  return reinterpret_cast<const __m128i*>(at);
}

// The voxel at `corner` and the next one on x, mixed by `shares`: the first's in the low half of each element.
[[gnu::target("avx2")]] inline __m256i along(const Patch::Voxel* corner, __m256i shares) {
  const __m256i pairs = _mm256_setr_epi8(0, -1, 8, -1, 1, -1, 9, -1, 2, -1, 10, -1, 3, -1, 11, -1,  //
                                         4, -1, 12, -1, 5, -1, 13, -1, 6, -1, 14, -1, 7, -1, 15, -1);
  const __m256i both = _mm256_broadcastsi128_si256(_mm_loadu_si128(vector_at(corner)));
  return _mm256_madd_epi16(_mm256_shuffle_epi8(both, pairs), shares);
}

[[gnu::target("avx2")]] inline __m256i between(__m256i a, __m256i b, __m256i fraction) {
  return _mm256_add_epi32(_mm256_slli_epi32(a, 8), _mm256_mullo_epi32(fraction, _mm256_sub_epi32(b, a)));
}

[[gnu::target("avx2")]] inline __m256i everywhere(std::uint32_t value) {
  return _mm256_set1_epi32(static_cast<int>(value));
}

[[gnu::target("avx2")]] inline void put(std::array<std::uint32_t, Patch::kLanes>& out, __m256i lanes) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out.data()), lanes);
}

}  // namespace

[[gnu::target("avx2")]] void blend_simd(const Patch::Voxel* voxels, const Place* places, std::size_t count,
                                        Sample* out) {
  constexpr std::size_t kUp = Patch::index(0, 1, 0), kBack = Patch::index(0, 0, 1);
  for (std::size_t i = 0; i < count; ++i) {
    const Place& place = places[i];
    const Patch::Voxel* corner = voxels + Patch::index(place.at(0), place.at(1), place.at(2));
    const std::uint32_t fx = place.fraction(0);
    const __m256i x = everywhere((kFraction - fx) | (fx << 16)), y = everywhere(place.fraction(1)),
                  z = everywhere(place.fraction(2));
    const __m256i near = between(along(corner, x), along(corner + kUp, x), y);
    const __m256i far = between(along(corner + kBack, x), along(corner + kBack + kUp, x), y);
    const __m256i sums = between(near, far, z);
    put(out[i].sums, sums);
    put(out[i].means, _mm256_srli_epi32(_mm256_add_epi32(sums, everywhere(kHalf)), 24));
    out[i].tsdf = distance(out[i].sums);
  }
}

// Two voxels at a time, of 6 bytes each; the last two are read from 4 bytes before them, to stay within the row.
[[gnu::target("avx2")]] unsigned copy_row_simd(const SubmapVoxel* from, Patch::Voxel* to, std::int16_t* tsdf) {
  static_assert(sizeof(SubmapVoxel) == 6 && offsetof(SubmapVoxel, weight) == 2 && offsetof(SubmapVoxel, rgb) == 3);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(from);
  const __m128i zero = _mm_setzero_si128();
  const __m128i spread = _mm_setr_epi8(0, 1, 2, 3, 4, 5, -1, -1, 6, 7, 8, 9, 10, 11, -1, -1);
  const __m128i bias = _mm_set1_epi64x(Patch::kTsdfZero), weight = _mm_set1_epi64x(0xFF0000),
                rgb = _mm_set1_epi64x(0xFFFFFF000000), flag = _mm_set1_epi64x(std::int64_t{1} << 48);
  const __m128i distances = _mm_setr_epi8(0, 1, 8, 9, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1);
  unsigned seen = 0;
  for (int pair = 0; pair < kBlockSide / 2; ++pair) {
    const bool last = pair == kBlockSide / 2 - 1;
    const __m128i raw = _mm_loadu_si128(vector_at(bytes + 12 * pair - (last ? 4 : 0)));
    const __m128i two = _mm_shuffle_epi8(last ? _mm_srli_si128(raw, 4) : raw, spread);
    const __m128i colorless = _mm_cmpeq_epi64(_mm_and_si128(two, rgb), zero);
    const __m128i unseen = _mm_cmpeq_epi64(_mm_and_si128(two, weight), zero);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to + 2 * pair),
                     _mm_or_si128(_mm_add_epi16(two, bias), _mm_andnot_si128(colorless, flag)));
    _mm_storeu_si32(tsdf + 2 * pair, _mm_shuffle_epi8(two, distances));
    seen |= (static_cast<unsigned>(_mm_movemask_pd(_mm_castsi128_pd(unseen))) ^ 3u) << (2 * pair);
  }
  return seen;
}

// Eight cells at a time: corners are paired up on x, then on y, then with what the z before left.
[[gnu::target("avx2")]] void one_surface_simd(const Patch::TsdfRow* tsdf, std::uint32_t* cells) {
  const __m128i limit = _mm_set1_epi16(Patch::kLargestSpread);
  __m128i least_before[kBlockSide], most_before[kBlockSide];
  for (int z = 0; z < Patch::kSide; ++z) {
    __m128i least_y = limit, most_y = limit;
    for (int y = 0; y < Patch::kSide; ++y, ++tsdf) {
      const __m128i a = _mm_loadu_si128(vector_at(tsdf->data())), b = _mm_loadu_si128(vector_at(tsdf->data() + 1));
      const __m128i least_x = _mm_min_epi16(a, b), most_x = _mm_max_epi16(a, b);
      if (y > 0) {
        const __m128i least = _mm_min_epi16(least_x, least_y), most = _mm_max_epi16(most_x, most_y);
        if (z > 0) {
          const __m128i spread = _mm_sub_epi16(_mm_max_epi16(most, most_before[y - 1]),  //
                                               _mm_min_epi16(least, least_before[y - 1]));
          const __m128i apart = _mm_packs_epi16(_mm_cmpgt_epi16(spread, limit), _mm_setzero_si128());
          *cells++ = ~static_cast<std::uint32_t>(_mm_movemask_epi8(apart)) & 0xFFu;
        }
        least_before[y - 1] = least;
        most_before[y - 1] = most;
      }
      least_y = least_x;
      most_y = most_x;
    }
  }
}

#else

void one_surface_simd(const Patch::TsdfRow* tsdf, std::uint32_t* cells) { one_surface_plain(tsdf, cells); }
void blend_simd(const Patch::Voxel* voxels, const Place* places, std::size_t count, Sample* out) {
  blend_plain(voxels, places, count, out);
}
unsigned copy_row_simd(const SubmapVoxel* from, Patch::Voxel* to, std::int16_t* tsdf) {
  return copy_row_plain(from, to, tsdf);
}

#endif

}  // namespace onemap::mapping::cells
