#include "hal/imaging/pair_by_time.hpp"

#include <cassert>

namespace onemap::hal::imaging {

namespace {

Duration apart(const PairByTime::Image& a, const PairByTime::Image& b) { return std::chrono::abs(a.time - b.time); }

}  // namespace

PairByTime::PairByTime(Duration max_apart, std::size_t room) : max_apart_(max_apart), room_(room) {
  colour_.waiting.reserve(room + 1);
  depth_.waiting.reserve(room + 1);
}

bool PairByTime::add(Stream& stream, Image image) {
  assert(stream.waiting.size() <= room_ && "next() was not asked");
  if (stream.any && image.time <= stream.last) return false;
  stream.any = true;
  stream.last = image.time;
  stream.waiting.push_back(image);
  return true;
}

PairByTime::Outcome PairByTime::next() {
  if (!colour_.waiting.empty() && !depth_.waiting.empty()) return both_wait();
  if (hopeless(colour_, depth_)) return lone(Kind::lone_colour);
  if (hopeless(depth_, colour_)) return lone(Kind::lone_depth);
  return {};
}

PairByTime::Outcome PairByTime::both_wait() {
  const Image colour = colour_.waiting.front(), depth = depth_.waiting.front();
  if (apart(colour, depth) > max_apart_) return lone(colour.time < depth.time ? Kind::lone_colour : Kind::lone_depth);
  const auto nearer = [](const Stream& stream, const Image& than, const Image& to) {
    return stream.waiting.size() > 1 && apart(stream.waiting[1], to) < apart(than, to);
  };
  if (nearer(colour_, colour, depth)) return lone(Kind::lone_colour);
  if (nearer(depth_, depth, colour)) return lone(Kind::lone_depth);
  colour_.waiting.erase(colour_.waiting.begin());
  depth_.waiting.erase(depth_.waiting.begin());
  return {Kind::pair, colour, depth};
}

// Whether the stream's oldest image must go: there is no room, or the other stream is past it.
bool PairByTime::hopeless(const Stream& stream, const Stream& other) const {
  if (stream.waiting.empty()) return false;
  return stream.waiting.size() > room_ || (other.any && other.last > stream.waiting.front().time + max_apart_);
}

PairByTime::Outcome PairByTime::lone(Kind kind) {
  ++unmatched_;
  std::vector<Image>& waiting = kind == Kind::lone_colour ? colour_.waiting : depth_.waiting;
  const Image image = waiting.front();
  waiting.erase(waiting.begin());
  return kind == Kind::lone_colour ? Outcome{kind, image, {}} : Outcome{kind, {}, image};
}

}  // namespace onemap::hal::imaging
