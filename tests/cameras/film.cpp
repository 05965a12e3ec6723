#include "film.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <stdexcept>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"

namespace onemap::test {

Film::Film(const std::string& room) {
  const auto address = hal::parse_camera_address(room);
  if (!address) throw std::runtime_error(address.error().text());
  const auto camera = hal::open_simulated(*address);
  if (!camera) throw std::runtime_error(camera.error().text());
  const hal::Intrinsics& k = (*camera)->intrinsics();
  if (k.width != kWidth || k.height != kHeight) throw std::runtime_error(room + ": not 640x480");
  hal::FramePool pool(k, 1);
  hal::Frame frame = pool.acquire();
  while ((*camera)->grab(frame, {}) == hal::Grab::frame)
    pictures_.push_back({{frame.rgb().begin(), frame.rgb().end()}, {frame.depth().begin(), frame.depth().end()}});
}

bool Projector::advance(bool wanted, Moment now) {
  constexpr auto kBeforeTheFirst = std::chrono::milliseconds(50);
  if (!wanted) running_ = false;
  if (!wanted || next_ >= pictures_) return false;
  if (!running_) {
    running_ = true;
    due_ = now + kBeforeTheFirst;
  }
  if (now < due_) return false;
  due_ += kInterval;
  const auto day = std::chrono::system_clock::now().time_since_epoch();
  fmt::print("picture {} {:.6f}\n", next_++, std::chrono::duration<double>(day).count());
  std::fflush(stdout);
  return true;
}

Moment Projector::next() const { return running_ ? due_ : Moment::max(); }

}  // namespace onemap::test
