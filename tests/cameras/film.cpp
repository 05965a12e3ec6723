#include "film.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"

namespace onemap::test {

namespace {

void write_bytes(std::ofstream& out, const Bytes& bytes) {
  const auto size = static_cast<std::uint32_t>(bytes.size());
  out.write(reinterpret_cast<const char*>(&size), sizeof size);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(size));
}

Bytes read_bytes(std::ifstream& in) {
  std::uint32_t size = 0;
  in.read(reinterpret_cast<char*>(&size), sizeof size);
  Bytes bytes(in.good() ? size : 0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

}  // namespace

Film Film::shoot(const std::string& room, const Develop& develop) {
  const auto address = hal::parse_camera_address(room);
  if (!address) throw std::runtime_error(address.error().text());
  const auto camera = hal::open_simulated(*address);
  if (!camera) throw std::runtime_error(camera.error().text());
  Film film;
  const hal::Intrinsics& k = (*camera)->intrinsics();
  film.width_ = static_cast<std::uint32_t>(k.width);
  film.height_ = static_cast<std::uint32_t>(k.height);
  hal::FramePool pool(k, 1);
  hal::Frame frame = pool.acquire();
  while ((*camera)->grab(frame, {}) == hal::Grab::frame) film.pictures_.push_back(develop(frame.view()));
  return film;
}

void Film::store(const std::string& file) const {
  std::ofstream out(file, std::ios::binary);
  out << width_ << ' ' << height_ << ' ' << pictures_.size() << '\n';
  for (const Picture& picture : pictures_) {
    write_bytes(out, picture.depth);
    write_bytes(out, picture.colour);
  }
  if (!out.flush()) throw std::runtime_error(file + ": cannot be written");
}

Film Film::load(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  Film film;
  std::size_t count = 0;
  in >> film.width_ >> film.height_ >> count;
  in.get();
  while (in.good() && film.pictures_.size() < count) {
    Bytes depth = read_bytes(in);
    film.pictures_.push_back({std::move(depth), read_bytes(in)});
  }
  if (!in.good() || count == 0) throw std::runtime_error(file + ": no film");
  return film;
}

bool FilmProjector::advance(bool wanted, Moment now) {
  constexpr auto kBeforeTheFirst = std::chrono::milliseconds(1500);  // as real ones; a robot that starts takes its time
  if (!wanted) running_ = false;
  if (!wanted || (next_ >= pictures_ && !again_)) return false;
  if (!running_) {
    running_ = true;
    due_ = now + kBeforeTheFirst;
  }
  if (now < due_) return false;
  due_ += kInterval;
  stamp_ = std::chrono::steady_clock::now().time_since_epoch();
  ++next_;
  if (again_) return true;
  const auto day = std::chrono::system_clock::now().time_since_epoch();
  fmt::print("picture {} {:.6f}\n", number(), std::chrono::duration<double>(day).count());
  std::fflush(stdout);
  return true;
}

Moment FilmProjector::next() const { return running_ ? due_ : Moment::max(); }

}  // namespace onemap::test
