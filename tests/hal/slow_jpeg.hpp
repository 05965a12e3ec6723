#pragma once
// A baseline JPEG decoder that follows ITU-T T.81 bit by bit and term by term, to hold the fast one against: one scan,
// 8 bits, Huffman codes, colour as JFIF has it. A colour's pixel is repeated for all pixels that it stands for. Not for
// damaged files: it throws.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace onemap::test {

class SlowJpeg {
 public:
  struct Huffman {
    std::array<int, 16> lengths{};  // how many codes have 1, 2, ... bits
    std::vector<std::uint8_t> values;
  };
  using Tables = std::array<Huffman, 8>;  // 0-3 of the DC, 4-7 of the AC coefficients

  // tables: for a file that leaves them out, as cameras do.
  explicit SlowJpeg(std::span<const std::uint8_t> file) : SlowJpeg(file, Tables()) {}
  SlowJpeg(std::span<const std::uint8_t> file, Tables tables) : tables_(std::move(tables)) {
    std::size_t at = 2;
    for (;;) {
      const std::uint8_t marker = file[at + 1];
      const auto body = file.subspan(at + 4, two(file, at + 2) - 2);
      at += 2 + two(file, at + 2);
      if (marker == 0xDB) read_quantisation(body);
      if (marker == 0xC4) read_huffman(body);
      if (marker == 0xDD) restart_ = two(body, 0);
      if (marker == 0xC0) read_frame(body);
      if (marker > 0xC0 && marker < 0xD0 && marker != 0xC4) throw std::runtime_error("not a baseline JPEG");
      if (marker != 0xDA) continue;
      for (std::size_t i = 0; i < components_.size(); ++i) components_[i].tables = body[2 + 2 * i];
      bits_ = file.subspan(at);
      read_scan();
      return;
    }
  }

  const Tables& tables() const { return tables_; }
  int width() const { return width_; }
  int height() const { return height_; }

  std::vector<std::uint8_t> rgb() const {
    std::vector<std::uint8_t> out;
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const double luma = at(components_[0], x, y);
        const bool grey = components_.size() == 1;
        const double cb = grey ? 0 : at(components_[1], x, y) - 128, cr = grey ? 0 : at(components_[2], x, y) - 128;
        for (const double value : {luma + 1.402 * cr, luma - 0.344136 * cb - 0.714136 * cr, luma + 1.772 * cb})
          out.push_back(static_cast<std::uint8_t>(std::lround(std::min(255.0, std::max(0.0, value)))));
      }
    return out;
  }

 private:
  struct Component {
    int h = 1, v = 1, quantisation = 0, tables = 0, dc = 0, columns = 0;
    std::vector<double> samples;  // of whole blocks
  };
  static std::size_t two(std::span<const std::uint8_t> bytes, std::size_t at) {
    return static_cast<std::size_t>(bytes[at] << 8 | bytes[at + 1]);
  }
  static constexpr std::array<int, 64> kZigzag{0,  1,  8,  16, 9,  2,  3,  10, 17, 24, 32, 25, 18, 11, 4,  5,
                                               12, 19, 26, 33, 40, 48, 41, 34, 27, 20, 13, 6,  7,  14, 21, 28,
                                               35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51,
                                               58, 59, 52, 45, 38, 31, 39, 46, 53, 60, 61, 54, 47, 55, 62, 63};

  void read_quantisation(std::span<const std::uint8_t> body) {
    for (std::size_t at = 0; at < body.size(); at += 65)
      for (std::size_t i = 0; i < 64; ++i)
        quantisation_.at(body[at])[static_cast<std::size_t>(kZigzag[i])] = body[at + 1 + i];
  }
  void read_huffman(std::span<const std::uint8_t> body) {
    for (std::size_t at = 0; at < body.size();) {
      Huffman& table = tables_.at((body[at] >> 4) * 4u + (body[at] & 3u));
      std::size_t values = 0;
      for (std::size_t i = 0; i < 16; ++i) values += static_cast<std::size_t>(table.lengths[i] = body[at + 1 + i]);
      const auto first = body.begin() + static_cast<std::ptrdiff_t>(at + 17);
      table.values.assign(first, first + static_cast<std::ptrdiff_t>(values));
      at += 17 + values;
    }
  }
  void read_frame(std::span<const std::uint8_t> body) {
    height_ = static_cast<int>(two(body, 1));
    width_ = static_cast<int>(two(body, 3));
    components_.resize(body[5]);
    for (std::size_t i = 0; i < components_.size(); ++i) {
      Component& c = components_[i];
      c.h = body[7 + 3 * i] >> 4, c.v = body[7 + 3 * i] & 15, c.quantisation = body[8 + 3 * i];
      most_h_ = std::max(most_h_, c.h), most_v_ = std::max(most_v_, c.v);
    }
    if (components_.size() == 1) components_[0].h = components_[0].v = most_h_ = most_v_ = 1;
  }

  int bit() {
    if (left_ == 0) {
      byte_ = bits_[next_++];
      if (byte_ == 0xFF && bits_[next_++] != 0) throw std::runtime_error("a marker within the scan");
      left_ = 8;
    }
    return byte_ >> --left_ & 1;
  }
  int number(int bits) {  // T.81, EXTEND
    int value = 0;
    for (int i = 0; i < bits; ++i) value = 2 * value + bit();
    return bits > 0 && value < 1 << (bits - 1) ? value - (1 << bits) + 1 : value;
  }
  int symbol(const Huffman& table) {
    int code = 0, first = 0;
    std::size_t index = 0;
    for (const int many : table.lengths) {
      code = 2 * code + bit();
      first *= 2;
      if (code - first < many) return table.values.at(index + static_cast<std::size_t>(code - first));
      first += many;
      index += static_cast<std::size_t>(many);
    }
    throw std::runtime_error("no such code");
  }

  void read_block(Component& c, int column, int row) {
    std::array<double, 64> f{};
    const auto& q = quantisation_.at(static_cast<std::size_t>(c.quantisation));
    c.dc += number(symbol(tables_.at(static_cast<std::size_t>(c.tables >> 4))));
    f[0] = c.dc * q[0];
    for (std::size_t k = 1; k < 64; ++k) {
      const int run_size = symbol(tables_.at(4u + static_cast<std::size_t>(c.tables & 3)));
      if (run_size == 0) break;
      k += static_cast<std::size_t>(run_size >> 4);
      const auto place = static_cast<std::size_t>(kZigzag.at(k));
      f[place] = number(run_size & 15) * q[place];
    }
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x)
        c.samples[static_cast<std::size_t>((8 * row + y) * c.columns + 8 * column + x)] = sample(f, x, y);
  }
  // T.81, A.3.3.
  static double sample(const std::array<double, 64>& f, int x, int y) {
    double sum = 0;
    for (int v = 0; v < 8; ++v)
      for (int u = 0; u < 8; ++u)
        sum += (u == 0 ? std::sqrt(0.5) : 1) * (v == 0 ? std::sqrt(0.5) : 1) * f[static_cast<std::size_t>(8 * v + u)] *
               std::cos((2 * x + 1) * u * M_PI / 16) * std::cos((2 * y + 1) * v * M_PI / 16);
    return std::min(255.0, std::max(0.0, std::round(sum / 4 + 128)));
  }

  void read_scan() {
    const int across = (width_ + 8 * most_h_ - 1) / (8 * most_h_), down = (height_ + 8 * most_v_ - 1) / (8 * most_v_);
    for (Component& c : components_) {
      c.columns = 8 * c.h * across;
      c.samples.resize(static_cast<std::size_t>(c.columns * 8 * c.v * down));
    }
    for (int unit = 0; unit < across * down; ++unit) {
      if (restart_ > 0 && unit > 0 && static_cast<std::size_t>(unit) % restart_ == 0) restart();
      for (Component& c : components_)
        for (int v = 0; v < c.v; ++v)
          for (int h = 0; h < c.h; ++h) read_block(c, unit % across * c.h + h, unit / across * c.v + v);
    }
  }
  void restart() {
    left_ = 0;
    if (bits_[next_] != 0xFF || (bits_[next_ + 1] & 0xF8) != 0xD0) throw std::runtime_error("no restart marker");
    next_ += 2;
    for (Component& c : components_) c.dc = 0;
  }
  double at(const Component& c, int x, int y) const {
    return c.samples[static_cast<std::size_t>(y * c.v / most_v_ * c.columns + x * c.h / most_h_)];
  }

  Tables tables_;
  std::array<std::array<int, 64>, 4> quantisation_{};
  std::vector<Component> components_;
  int width_ = 0, height_ = 0, most_h_ = 1, most_v_ = 1, byte_ = 0, left_ = 0;
  std::size_t restart_ = 0, next_ = 0;
  std::span<const std::uint8_t> bits_;
};

}  // namespace onemap::test
