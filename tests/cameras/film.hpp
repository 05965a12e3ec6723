#pragma once
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "usb_device.hpp"

namespace onemap::test {

// The pictures of a simulated room, 640x480, drawn beforehand so that a camera can show them at its pace.
class Film {
 public:
  static constexpr std::size_t kWidth = 640, kHeight = 480, kPixels = kWidth * kHeight;
  struct Picture {
    std::vector<std::uint8_t> rgb;
    std::vector<std::uint16_t> depth;  // 5000 a metre
  };
  explicit Film(const std::string& room);  // throws when the address is wrong
  const std::vector<Picture>& pictures() const { return pictures_; }

 private:
  std::vector<Picture> pictures_;
};

// Which picture of a film is to be seen. It goes on while both streams are wanted, and stands still otherwise.
class Projector {
 public:
  static constexpr auto kInterval = std::chrono::nanoseconds(1'000'000'000 / 30);
  explicit Projector(std::size_t pictures) : pictures_(pictures) {}

  // True: a new one is due, number(). Says it on stdout, with the time of day.
  bool advance(bool wanted, Moment now);
  std::size_t number() const { return next_ - 1; }
  std::size_t shown() const { return next_; }
  Moment since() const { return due_ - kInterval; }  // when number() was due
  Moment next() const;
  void stop() { running_ = false; }

 private:
  std::size_t pictures_, next_ = 0;
  bool running_ = false;
  Moment due_{};
};

}  // namespace onemap::test
