#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hal/frame.hpp"
#include "usb_device.hpp"

namespace onemap::test {

// The pictures of a simulated room as a camera sends them, drawn beforehand: a camera shows them at its pace, and a
// machine that is emulated has better things to do.
class Film {
 public:
  struct Picture {
    Bytes depth, colour;
  };
  using Develop = std::function<Picture(const hal::FrameView&)>;  // into the bytes of a kind of camera

  static Film shoot(const std::string& room, const Develop& develop);  // all throw, with what is wrong
  static Film load(const std::string& file);
  void store(const std::string& file) const;

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }
  const std::vector<Picture>& pictures() const { return pictures_; }

 private:
  std::uint32_t width_ = 0, height_ = 0;
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
