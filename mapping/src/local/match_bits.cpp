#include <algorithm>

#include "match_internal.hpp"
#include "twin.hpp"

namespace onemap::mapping::match {

namespace {

ONEMAP_TWIN_BODY void search_bits_body(std::span<const BinaryFeature> a, std::span<const BinaryFeature> b,
                                       std::span<TwoNearest> forward, std::span<TwoNearest> backward) {
  std::fill(backward.begin(), backward.end(), TwoNearest{});
  for (std::size_t i = 0; i < a.size(); ++i) {
    TwoNearest nearest;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::int32_t bits = hamming_distance(a[i].bits, b[j].bits);
      const std::int32_t distance = a[i].laplacian == b[j].laplacian ? bits : TwoNearest::kNoDistance;
      offer(nearest, distance, j);
      offer(backward[j], distance, i);
    }
    forward[i] = nearest;
  }
}

}  // namespace

ONEMAP_TWIN(search_bits,
            (std::span<const BinaryFeature> a, std::span<const BinaryFeature> b, std::span<TwoNearest> forward,
             std::span<TwoNearest> backward),
            (a, b, forward, backward))

}  // namespace onemap::mapping::match
