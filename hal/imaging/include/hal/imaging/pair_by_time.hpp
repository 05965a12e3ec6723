#pragma once
#include <cstdint>
#include <vector>

#include "hal/base/time.hpp"

namespace onemap::hal::imaging {

// Finds the colour and depth images that belong together in two live streams, by their times alone. It holds no pixels:
// `buffer` is the caller's name for them. Memory is taken once.
class PairByTime {
 public:
  struct Image {
    FrameTime time{};
    std::uint32_t buffer = 0;
    bool operator==(const Image&) const = default;
  };
  enum class Kind { nothing, pair, lone_colour, lone_depth };
  struct Outcome {
    Kind kind = Kind::nothing;
    Image colour, depth;  // what kind says is there
  };

  // Images at most max_apart from each other are a pair; at most `room` images of each stream wait.
  PairByTime(Duration max_apart, std::size_t room);

  // A new image. False, and nothing happens, when its time does not come after the stream's last. Between two of them
  // next() is asked until there is nothing.
  bool add_colour(Image image) { return add(colour_, image); }
  bool add_depth(Image image) { return add(depth_, image); }

  // What is settled, oldest first; ask until there is nothing. A pair is the nearest partner among the images that have
  // arrived: it is not held back for one that may still come. An image that can have no partner any more, or that makes
  // room, is lone and counted.
  Outcome next();
  std::uint64_t unmatched() const { return unmatched_; }

 private:
  struct Stream {
    std::vector<Image> waiting;  // strictly increasing times
    bool any = false;
    FrameTime last{};
  };
  bool add(Stream& stream, Image image);
  Outcome both_wait();
  bool hopeless(const Stream& stream, const Stream& other) const;
  Outcome lone(Kind kind);

  const Duration max_apart_;
  const std::size_t room_;
  Stream colour_, depth_;
  std::uint64_t unmatched_ = 0;
};

}  // namespace onemap::hal::imaging
