#pragma once
#include <png.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "render/image.hpp"

namespace onemap::test {

// Reads a PNG by libpng's simplified interface; an empty image if it cannot.
inline render::Image read_png(const std::string& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&png, path.c_str()) == 0) return {};
  png.format = PNG_FORMAT_RGB;
  render::Image image(static_cast<int>(png.width), static_cast<int>(png.height));
  if (png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr) == 0) return {};
  return image;
}

// How two pictures of the same size differ, over all channels.
struct PictureDifference {
  bool same_size = false;
  double mean = 0;      // grey levels
  double outliers = 0;  // share of pixels that differ by more than 24 levels in a channel
};

inline PictureDifference compare(const render::Image& a, const render::Image& b) {
  PictureDifference result;
  result.same_size = a.width == b.width && a.height == b.height && !a.rgb.empty();
  if (!result.same_size) return result;
  double sum = 0;
  std::size_t outliers = 0;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) {
    int worst = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const int difference = std::abs(int{a.rgb[i + c]} - int{b.rgb[i + c]});
      sum += difference;
      worst = std::max(worst, difference);
    }
    outliers += worst > 24 ? 1 : 0;
  }
  result.mean = sum / static_cast<double>(a.rgb.size());
  result.outliers = static_cast<double>(outliers) / static_cast<double>(a.rgb.size() / 3);
  return result;
}

}  // namespace onemap::test
