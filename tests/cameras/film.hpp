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

// Which picture of a film is to be seen.
class Projector {
 public:
  virtual ~Projector() = default;
  virtual bool advance(bool wanted, Moment now) = 0;  // true: a new one is due, number()
  virtual std::size_t number() const = 0;
  virtual std::chrono::nanoseconds stamp() const = 0;  // of number(), by the camera's clock
  virtual Moment since() const = 0;                    // when number() was due
  virtual Moment next() const = 0;
  virtual void stop() = 0;  // the camera was pulled out
};

// 30 pictures a second, once or over and over. It goes on while both streams are wanted, and stands still otherwise.
class FilmProjector final : public Projector {
 public:
  static constexpr auto kInterval = std::chrono::nanoseconds(1'000'000'000 / 30);
  explicit FilmProjector(std::size_t pictures, bool again = false) : pictures_(pictures), again_(again) {}

  bool advance(bool wanted, Moment now) override;  // of a film that is shown once it says so on stdout, with the time
  std::size_t number() const override { return (next_ - 1) % pictures_; }
  std::size_t shown() const { return next_; }
  std::chrono::nanoseconds stamp() const override { return stamp_; }
  Moment since() const override { return due_ - kInterval; }
  Moment next() const override;
  void stop() override { running_ = false; }

 private:
  const std::size_t pictures_;
  const bool again_;
  std::size_t next_ = 0;
  bool running_ = false;
  Moment due_{};
  std::chrono::nanoseconds stamp_{};
};

}  // namespace onemap::test
