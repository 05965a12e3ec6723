#pragma once
// Cameras that umockdev plays, with images whose every value is known, and the files that calibrate them.
#include <algorithm>

#include "hal/imaging/encode_image.hpp"
#include "hal/v4l2/mock_uvc.hpp"
#include "support/temp_folder.hpp"

namespace onemap::test {

inline constexpr auto kZ16 = V4L2_PIX_FMT_Z16, kYuyv = V4L2_PIX_FMT_YUYV, kUyvy = V4L2_PIX_FMT_UYVY,
                      kGrey = V4L2_PIX_FMT_GREY;

// Depth 1000 + x + 2 y + sequence + offset millimetres.
inline MockNodeConfig depth_node(int offset = 0) {
  MockNodeConfig config;
  config.formats = {kZ16};
  config.sizes = {{640, 480}, {320, 240}};
  config.content = [offset](const MockMode& mode, std::uint32_t sequence, std::uint8_t* out, std::uint32_t stride) {
    for (std::uint32_t y = 0; y < mode.height; ++y)
      for (std::uint32_t x = 0; x < mode.width; ++x) {
        const std::uint32_t value = 1000 + x + 2 * y + sequence + static_cast<std::uint32_t>(offset);
        out[y * stride + 2 * x] = static_cast<std::uint8_t>(value);
        out[y * stride + 2 * x + 1] = static_cast<std::uint8_t>(value >> 8);
      }
  };
  return config;
}

// Grey stripes that walk, as YUYV (or UYVY) without colour.
inline MockNodeConfig colour_node(std::vector<std::uint32_t> formats = {kYuyv}) {
  MockNodeConfig config;
  config.formats = std::move(formats);
  config.sizes = {{640, 480}, {320, 240}};
  config.phase_us = 9000;
  config.content = [](const MockMode& mode, std::uint32_t sequence, std::uint8_t* out, std::uint32_t stride) {
    const std::uint32_t luma = mode.format == kUyvy ? 1 : 0;
    for (std::uint32_t y = 0; y < mode.height; ++y)
      for (std::uint32_t x = 0; x < mode.width; ++x) {
        out[y * stride + 2 * x + luma] = static_cast<std::uint8_t>(16 + (x + sequence) % 200);
        out[y * stride + 2 * x + 1 - luma] = 128;
      }
  };
  return config;
}

// JPEG in place of rows: red 200, green 100, blue rises along the rows, so that something is in the picture.
inline void jpeg_images(const MockMode& mode, std::uint32_t, std::uint8_t* out, std::uint32_t) {
  const hal::imaging::ImageSize size{static_cast<int>(mode.width), static_cast<int>(mode.height)};
  std::vector<std::uint8_t> rgb(3 * size.pixels()), file;
  for (std::size_t i = 0; i < rgb.size(); i += 3)
    rgb[i] = 200, rgb[i + 1] = 100, rgb[i + 2] = static_cast<std::uint8_t>(i / 3 % mode.width / 4);
  if (hal::imaging::encode_jpeg(size, rgb, 95, file)) std::ranges::copy(file, out);
}

inline const char* const kRegistered = "width 640\nheight 480\nfx 600\nfy 600\ncx 319.5\ncy 239.5\ndepth_scale 1000\n";
inline const char* const kDepthLens =
    "depth_width 640\ndepth_height 480\ndepth_fx 600\ndepth_fy 600\ndepth_cx 319.5\ndepth_cy 239.5\n";

// A machine with its cameras.
class Machine {
 public:
  Machine() {
    if (!MockTestbed::wrapped()) return;
    testbed_ = std::make_unique<MockTestbed>();
    folder_.write("registered.txt", kRegistered);
    folder_.write("two-lenses.txt", std::string(kRegistered) + kDepthLens + "colour_from_depth_x 0.02\n");
  }
  std::string missing() const {
    return testbed_ ? "" : "umockdev-wrapper is not around this process (package umockdev)";
  }
  MockUvc& add(int port, int number, MockNodeConfig depth, MockNodeConfig colour,
               const std::string& usb_id = "8086:0b07") {
    cameras_.push_back(
        std::make_unique<MockUvc>(*testbed_, port, usb_id, "Mock depth camera", std::move(depth), std::move(colour)));
    cameras_.back()->plug(number);
    return *cameras_.back();
  }
  std::string file(const char* name) const { return folder_ / name; }
  void write(const char* name, const std::string& text) { folder_.write(name, text); }
  MockUvc& camera(std::size_t i) { return *cameras_[i]; }

 private:
  TempFolder folder_;
  std::unique_ptr<MockTestbed> testbed_;
  std::vector<std::unique_ptr<MockUvc>> cameras_;
};

}  // namespace onemap::test
