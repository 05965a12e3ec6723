#pragma once
#include <cstddef>
#include <cstdint>

#include "footprints.hpp"

// The nearest of what covers a pixel: the second half of DepthRegistration's inner loop.
namespace onemap::hal::imaging::nearest {

// While readings are put in, an image holds depths less 1, so that nothing is farther than all.
inline constexpr std::uint16_t kNothing = 65535;

// A row's readings into the image, whose rows have `columns` pixels. In any order it is the same.
void keep_plain(const footprints::Covered& row, std::size_t columns, std::uint16_t* image);
void keep_simd(const footprints::Covered& row, std::size_t columns, std::uint16_t* image);  // where simd_available()

}  // namespace onemap::hal::imaging::nearest
