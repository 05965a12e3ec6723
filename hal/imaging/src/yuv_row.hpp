#pragma once
#include <cstddef>
#include <cstdint>

// A row of Y U Y V or U Y V Y to RGB: the inner loop of yuyv_to_rgb() and uyvy_to_rgb(), and its twin of AVX2, which
// gives the same bytes.
namespace onemap::hal::imaging::yuv {

enum class Order { yuyv, uyvy };

// in: 2 * width bytes, width even; rgb: 3 * width.
void row_plain(Order order, const std::uint8_t* in, std::size_t width, std::uint8_t* rgb);
void row_simd(Order order, const std::uint8_t* in, std::size_t width, std::uint8_t* rgb);  // where simd_available()

// BT.601: R = 1.164 (Y - 16) + 1.596 V', G = 1.164 (Y - 16) - 0.392 U' - 0.813 V', B = 1.164 (Y - 16) + 2.017 U', in
// 1/256.
inline constexpr int kY = 298, kRedOfV = 409, kGreenOfU = -100, kGreenOfV = -208, kBlueOfU = 516, kHalf = 128;

}  // namespace onemap::hal::imaging::yuv
