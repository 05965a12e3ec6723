#include <algorithm>

#include "match_internal.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace onemap::mapping::match {

namespace {

constexpr std::size_t kLanes = 8;                    // features of b at once
constexpr std::size_t kPairs = 32;                   // of components: what one multiply-add takes
constexpr std::size_t kBlock = kPairs * kLanes * 2;  // packed elements of eight features
constexpr std::size_t kFields = 5;                   // norm, laplacian, best, second, index: eight of each a block
constexpr std::int32_t kNoFeature = 127;             // a laplacian that nobody has: the last block's empty lanes

std::size_t blocks(std::size_t count) { return (count + kLanes - 1) / kLanes; }

}  // namespace

std::size_t packed_elements(std::size_t count) { return blocks(count) * kBlock; }
std::size_t block_elements(std::size_t count) { return blocks(count) * kFields * kLanes; }

#if defined(__x86_64__)

bool simd_available() { return __builtin_cpu_supports("avx2") != 0; }

namespace {

std::int32_t squared_norm(const Descriptor& d) {
  std::int32_t sum = 0;
  for (const std::int8_t c : d.v) sum += c * c;
  return sum;
}

// Component pair p of the eight features of a block stands together: packed[block][p][lane][2].
void pack(const FeatureSet& b, bool same_laplacian, std::span<std::int16_t> packed, std::span<std::int32_t> block) {
  for (std::size_t k = 0; k < blocks(b.size()); ++k) {
    std::int16_t* out = packed.data() + k * kBlock;
    std::int32_t* fields = block.data() + k * kFields * kLanes;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t j = k * kLanes + lane;
      const bool real = j < b.size();
      static constexpr Descriptor kEmpty{};
      const Descriptor& d = real ? b.descriptors[j] : kEmpty;
      for (std::size_t p = 0; p < kPairs; ++p) {
        out[(p * kLanes + lane) * 2] = std::int16_t{d.v[2 * p]};
        out[(p * kLanes + lane) * 2 + 1] = std::int16_t{d.v[2 * p + 1]};
      }
      fields[lane] = squared_norm(d);
      fields[kLanes + lane] = !real ? kNoFeature : same_laplacian ? b.keypoints[j].laplacian : 0;
      fields[2 * kLanes + lane] = fields[3 * kLanes + lane] = TwoNearest::kNoDistance;
      fields[4 * kLanes + lane] = -1;
    }
  }
}

struct Lanes {
  __m256i best, second, index;
};

// d replaces what it beats; equal distances leave the earlier index.
[[gnu::target("avx2"), gnu::always_inline]] inline void offer(Lanes& n, __m256i d, __m256i index) {
  n.index = _mm256_blendv_epi8(n.index, index, _mm256_cmpgt_epi32(n.best, d));
  n.second = _mm256_min_epi32(n.second, _mm256_max_epi32(n.best, d));
  n.best = _mm256_min_epi32(n.best, d);
}

[[gnu::target("avx2"), gnu::always_inline]] inline __m256i load(const void* p) {
  return _mm256_loadu_si256(static_cast<const __m256i*>(p));
}
[[gnu::target("avx2"), gnu::always_inline]] inline void store(void* p, __m256i v) {
  _mm256_storeu_si256(static_cast<__m256i*>(p), v);
}

// Dot products of one descriptor (32 pairs of 16-bit components) with a block's eight.
[[gnu::target("avx2"), gnu::always_inline]] inline __m256i dot(const std::int32_t* pairs, const std::int16_t* packed) {
  __m256i even = _mm256_setzero_si256(), odd = even;
  for (std::size_t p = 0; p < kPairs; p += 2) {
    even = _mm256_add_epi32(even, _mm256_madd_epi16(_mm256_set1_epi32(pairs[p]), load(packed + p * kLanes * 2)));
    odd =
        _mm256_add_epi32(odd, _mm256_madd_epi16(_mm256_set1_epi32(pairs[p + 1]), load(packed + (p + 1) * kLanes * 2)));
  }
  return _mm256_add_epi32(even, odd);
}

TwoNearest merge(const Lanes& lanes) {
  alignas(32) std::int32_t best[kLanes], second[kLanes], index[kLanes];
  std::copy_n(reinterpret_cast<const std::int32_t*>(&lanes.best), kLanes, best);
  std::copy_n(reinterpret_cast<const std::int32_t*>(&lanes.second), kLanes, second);
  std::copy_n(reinterpret_cast<const std::int32_t*>(&lanes.index), kLanes, index);
  std::size_t winner = 0;
  for (std::size_t i = 1; i < kLanes; ++i)
    if (best[i] < best[winner] || (best[i] == best[winner] && index[i] < index[winner])) winner = i;
  TwoNearest out{best[winner], second[winner], index[winner]};
  for (std::size_t i = 0; i < kLanes; ++i)
    if (i != winner) out.second = std::min(out.second, best[i]);
  return out;
}

[[gnu::target("avx2")]] TwoNearest search_one(const Descriptor& a, std::int32_t a_laplacian, std::int32_t a_index,
                                              std::size_t block_count, const std::int16_t* packed,
                                              std::int32_t* fields) {
  alignas(32) std::int32_t pairs[kPairs];
  for (std::size_t i = 0; i < 4; ++i)
    store(pairs + i * 8, _mm256_cvtepi8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(a.v.data() + 16 * i))));
  const __m256i none = _mm256_set1_epi32(TwoNearest::kNoDistance), laplacian = _mm256_set1_epi32(a_laplacian);
  const __m256i norm = _mm256_set1_epi32(squared_norm(a)), self = _mm256_set1_epi32(a_index);
  __m256i index = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  Lanes forward{none, none, _mm256_set1_epi32(-1)};
  for (std::size_t k = 0; k < block_count; ++k, packed += kBlock, fields += kFields * kLanes) {
    // |a - b|^2 = |a|^2 + |b|^2 - 2 a b, exactly.
    __m256i d = _mm256_sub_epi32(_mm256_add_epi32(norm, load(fields)), _mm256_slli_epi32(dot(pairs, packed), 1));
    d = _mm256_blendv_epi8(none, d, _mm256_cmpeq_epi32(load(fields + kLanes), laplacian));
    offer(forward, d, index);
    Lanes backward{load(fields + 2 * kLanes), load(fields + 3 * kLanes), load(fields + 4 * kLanes)};
    offer(backward, d, self);
    store(fields + 2 * kLanes, backward.best);
    store(fields + 3 * kLanes, backward.second);
    store(fields + 4 * kLanes, backward.index);
    index = _mm256_add_epi32(index, _mm256_set1_epi32(kLanes));
  }
  return merge(forward);
}

}  // namespace

void search_simd(const FeatureSet& a, const FeatureSet& b, bool same_laplacian, std::span<std::int16_t> packed,
                 std::span<std::int32_t> block, std::span<TwoNearest> forward, std::span<TwoNearest> backward) {
  pack(b, same_laplacian, packed, block);
  const std::size_t count = blocks(b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    forward[i] = search_one(a.descriptors[i], same_laplacian ? a.keypoints[i].laplacian : 0,
                            static_cast<std::int32_t>(i), count, packed.data(), block.data());
  for (std::size_t j = 0; j < b.size(); ++j) {
    const std::int32_t* fields = block.data() + j / kLanes * kFields * kLanes + j % kLanes;
    backward[j] = {fields[2 * kLanes], fields[3 * kLanes], fields[4 * kLanes]};
  }
}

#else

bool simd_available() { return false; }
void search_simd(const FeatureSet&, const FeatureSet&, bool, std::span<std::int16_t>, std::span<std::int32_t>,
                 std::span<TwoNearest>, std::span<TwoNearest>) {}

#endif

}  // namespace onemap::mapping::match
