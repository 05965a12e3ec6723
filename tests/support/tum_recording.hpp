#pragma once
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/geometry.hpp"
#include "support/text_of.hpp"

// Depth images and ground truth of a recording in TUM layout, read plainly: independent of the replay backend.
namespace onemap::test {

class TumRecording {
 public:
  struct Depth {
    double time_s;
    std::string file;
  };

  explicit TumRecording(const std::filesystem::path& folder) {
    read_calibration(folder / "calibration.txt");
    for (const auto& fields : lines(folder / "depth.txt")) {
      depths_.push_back({std::stod(fields.at(0)), (folder / fields.at(1)).string()});
    }
    for (const auto& f : lines(folder / "groundtruth.txt")) {
      Stamped s;
      s.time_s = std::stod(f.at(0));
      s.pose.t = {std::stod(f.at(1)), std::stod(f.at(2)), std::stod(f.at(3))};
      s.q = {std::stod(f.at(7)), std::stod(f.at(4)), std::stod(f.at(5)), std::stod(f.at(6))};
      truth_.push_back(s);
    }
  }

  bool ok() const { return !depths_.empty() && !truth_.empty(); }
  const hal::Intrinsics& intrinsics() const { return intrinsics_; }
  const std::vector<Depth>& depths() const { return depths_; }

  std::vector<std::uint16_t> depth(std::size_t i) const { return read_png16(depths_.at(i).file); }

  // Ground truth camera to world at the time of a depth image; false where the truth has a gap.
  bool truth(std::size_t i, mapping::Pose& T_world_camera) const {
    return truth_at(depths_.at(i).time_s, T_world_camera);
  }
  bool truth_at(double t, mapping::Pose& T_world_camera) const {
    const auto after = std::lower_bound(truth_.begin(), truth_.end(), t,
                                        [](const Stamped& s, double time) { return s.time_s < time; });
    if (after == truth_.begin() || after == truth_.end()) return false;
    const Stamped& b = *after;
    const Stamped& a = *(after - 1);
    if (b.time_s - a.time_s > 0.05) return false;
    const double share = (t - a.time_s) / (b.time_s - a.time_s);
    double dot = 0;
    for (std::size_t k = 0; k < 4; ++k) dot += a.q[k] * b.q[k];
    std::array<double, 4> q{};
    for (std::size_t k = 0; k < 4; ++k) q[k] = (1 - share) * a.q[k] + (dot < 0 ? -share : share) * b.q[k];
    T_world_camera.R = mapping::from_quaternion_wxyz(q);
    T_world_camera.t = (1 - share) * a.pose.t + share * b.pose.t;
    return true;
  }

 private:
  struct Stamped {
    double time_s = 0;
    mapping::Pose pose;
    std::array<double, 4> q{};
  };

  static std::vector<std::vector<std::string>> lines(const std::filesystem::path& file) {
    std::vector<std::vector<std::string>> out;
    for (const std::string& line : lines_of(file)) {
      if (line.empty() || line[0] == '#') continue;
      std::istringstream fields(line);
      std::vector<std::string> words;
      for (std::string word; fields >> word;) words.push_back(word);
      out.push_back(words);
    }
    return out;
  }

  void read_calibration(const std::filesystem::path& file) {
    for (const auto& f : lines(file)) {
      const double value = std::stod(f.at(1));
      if (f[0] == "fx") intrinsics_.fx = value;
      if (f[0] == "fy") intrinsics_.fy = value;
      if (f[0] == "cx") intrinsics_.cx = value;
      if (f[0] == "cy") intrinsics_.cy = value;
      if (f[0] == "k1") intrinsics_.k1 = value;
      if (f[0] == "k2") intrinsics_.k2 = value;
      if (f[0] == "p1") intrinsics_.p1 = value;
      if (f[0] == "p2") intrinsics_.p2 = value;
      if (f[0] == "k3") intrinsics_.k3 = value;
      if (f[0] == "depth_scale") intrinsics_.depth_scale = value;
    }
  }

  // A 16-bit grey image; empty when it cannot be read. (The simplified interface of libpng would apply a gamma.)
  std::vector<std::uint16_t> read_png16(const std::string& file) const {
    const auto w = static_cast<std::size_t>(intrinsics_.width), h = static_cast<std::size_t>(intrinsics_.height);
    std::FILE* in = std::fopen(file.c_str(), "rb");
    if (in == nullptr) return {};
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, in);
    png_read_png(png, info, PNG_TRANSFORM_SWAP_ENDIAN, nullptr);
    std::vector<std::uint16_t> out;
    if (png_get_image_width(png, info) == w && png_get_image_height(png, info) == h &&
        png_get_bit_depth(png, info) == 16) {
      out.resize(w * h);
      png_bytepp rows = png_get_rows(png, info);
      for (std::size_t v = 0; v < h; ++v) std::copy_n(rows[v], 2 * w, reinterpret_cast<png_bytep>(out.data() + v * w));
    }
    png_destroy_read_struct(&png, &info, nullptr);
    std::fclose(in);
    return out;
  }

  hal::Intrinsics intrinsics_;
  std::vector<Depth> depths_;
  std::vector<Stamped> truth_;
};

}  // namespace onemap::test
