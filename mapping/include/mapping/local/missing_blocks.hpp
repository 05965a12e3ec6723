#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/local/block_key.hpp"

namespace onemap::mapping {

// The blocks that one frame asked for in vain, each once, so that they can be counted. Memory is taken in the
// constructor.
class MissingBlocks {
 public:
  explicit MissingBlocks(std::size_t most);  // so many different ones in a frame; more are not noted
  static std::size_t bytes_for(std::size_t most);

  void begin_frame();                           // nothing is missing yet
  bool add(const BlockKey& key);                // whether it is noted now for the first time in this frame
  std::size_t count() const { return count_; }  // in this frame

 private:
  struct Slot {
    BlockKey key;
    std::uint32_t frame = 0;  // that noted it
  };
  std::size_t most_, count_ = 0;
  std::uint32_t frame_ = 1;
  std::vector<Slot> slots_;  // open addressing; a power of two, at most half of it used
};

}  // namespace onemap::mapping
