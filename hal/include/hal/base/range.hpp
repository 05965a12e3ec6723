#pragma once

namespace onemap {

// From least to most, both included. NaN is in no range.
template <class T>
struct Range {
  T least, most;
  constexpr bool holds(T value) const { return value >= least && value <= most; }
};

}  // namespace onemap
