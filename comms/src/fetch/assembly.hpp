#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "comms/wire/frames.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// One record that is being put together from fragments. Each fragment is missing, asked for (under a serial) or here.
// How many there are is a guess until the first one comes and says it.
class Assembly {
 public:
  explicit Assembly(Memory& memory = heap()) : fragments_(&memory), body_(&memory) {}
  void begin(std::uint32_t guessed_fragments);  // nothing is here, and nothing is asked for

  bool known() const { return known_; }
  bool agrees(const wire::Data& data) const;  // about kind, size and hash, with what is known
  void learn(const wire::Data& data);         // kind, size and hash; fragments beyond the end go
  void restart();                             // forgets all that came and all that was asked

  void asked(std::uint32_t fragment, std::uint32_t serial);
  void lost(std::uint32_t fragment);  // what was asked for is missing again
  void withdrawn();                   // all that was asked for is
  enum class Kept { first, again };
  Kept keep(const wire::Data& data);  // known, and agreeing

  std::optional<std::uint32_t> serial_of(std::uint32_t fragment) const;  // when it is asked for
  bool is_missing(std::uint32_t fragment) const { return fragments_[fragment] == kMissing; }
  std::uint32_t fragments() const { return static_cast<std::uint32_t>(fragments_.size()); }
  std::uint32_t missing() const { return missing_; }
  bool complete() const { return here_ == fragments_.size(); }
  bool hash_is_right() const { return wire::body_hash(kind_, body_) == hash_; }

  std::uint16_t kind() const { return kind_; }
  std::uint8_t hops() const { return hops_; }  // links that it came over: the most of any fragment
  std::uint32_t total_bytes() const { return total_bytes_; }
  std::span<const std::uint8_t> body() const { return body_; }  // the payload

  static constexpr std::uint32_t kMissing = 0, kHere = 0xFFFFFFFF;  // no serials

 private:
  void count_missing();
  bool known_ = false;
  std::uint16_t kind_ = 0;
  std::uint8_t hops_ = 0;
  std::uint32_t total_bytes_ = 0;
  std::uint64_t hash_ = 0;
  std::uint32_t here_ = 0, missing_ = 0;
  std::pmr::vector<std::uint32_t> fragments_;
  std::pmr::vector<std::uint8_t> body_;
};

}  // namespace onemap::comms
