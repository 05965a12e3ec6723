#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace onemap {

// Writes an integer, lowest byte first, and answers where the next one goes.
template <std::integral T>
std::uint8_t* put_little_endian(std::uint8_t* at, T value) {
  const auto bits = static_cast<std::make_unsigned_t<T>>(value);
  for (std::size_t i = 0; i < sizeof(T); ++i) *at++ = static_cast<std::uint8_t>(bits >> (8 * i));
  return at;
}

// Appends little-endian integers to a byte vector: the one way in which records and datagrams are encoded.
class ByteWriter {
 public:
  explicit ByteWriter(std::vector<std::uint8_t>& out) : out_(out) {}
  template <std::integral T>
  void put(T value) {
    const std::size_t at = out_.size();
    out_.resize(at + sizeof(T));
    put_little_endian(out_.data() + at, value);
  }
  void bytes(std::span<const std::uint8_t> data) {
    const auto at = static_cast<std::ptrdiff_t>(out_.size());
    out_.resize(out_.size() + data.size());
    std::copy(data.begin(), data.end(), out_.begin() + at);
  }
  std::size_t size() const { return out_.size(); }

 private:
  std::vector<std::uint8_t>& out_;
};

// Reads what ByteWriter wrote. Total: reading past the end yields zeros and makes ok() false for good; a decoder checks
// ok() (and done(), when nothing may follow) once at the end.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> data) : data_(data) {}
  template <std::integral T>
  T get() {
    if (remaining() < sizeof(T)) return fail<T>();
    std::make_unsigned_t<T> bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bits = static_cast<std::make_unsigned_t<T>>(bits |
                                                  (static_cast<std::make_unsigned_t<T>>(data_[at_ + i]) << (8 * i)));
    at_ += sizeof(T);
    return static_cast<T>(bits);
  }
  std::span<const std::uint8_t> bytes(std::size_t count) {
    if (remaining() < count) {
      fail<std::uint8_t>();
      return {};
    }
    auto part = data_.subspan(at_, count);
    at_ += count;
    return part;
  }
  std::size_t remaining() const { return data_.size() - at_; }
  bool ok() const { return ok_; }
  bool done() const { return ok_ && remaining() == 0; }

 private:
  template <class T>
  T fail() {
    ok_ = false;
    at_ = data_.size();
    return T{};
  }
  std::span<const std::uint8_t> data_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

// Zeros where they are not there.
template <std::size_t N>
void get_bytes(ByteReader& in, std::array<std::uint8_t, N>& out) {
  const auto bytes = in.bytes(N);
  std::fill(std::copy(bytes.begin(), bytes.end(), out.begin()), out.end(), std::uint8_t{0});
}

}  // namespace onemap
