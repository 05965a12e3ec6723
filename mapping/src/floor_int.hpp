#pragma once

namespace onemap::mapping {

// The largest whole number that is not above x, which must fit; without the call that floor() is before SSE4.
template <class Int, class Real>
Int floor_int(Real x) {
  const auto i = static_cast<Int>(x);
  return static_cast<Int>(i - (static_cast<Real>(i) > x ? 1 : 0));
}

}  // namespace onemap::mapping
