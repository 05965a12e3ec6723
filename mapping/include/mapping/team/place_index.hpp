#pragma once
#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "hal/base/ids.hpp"
#include "mapping/local/match.hpp"
#include "mapping/local/zeroed_allocator.hpp"

namespace onemap::mapping {

// A keyframe of one life of a robot.
struct PlaceId {
  RobotId robot;
  std::uint64_t incarnation = 0;
  std::uint32_t keyframe = 0;
  auto operator<=>(const PlaceId&) const = default;
};

// A keyframe that may show what was asked for.
struct Place {
  PlaceId id;
  std::uint64_t votes = 0;     // larger is likelier; comparable between queries of one index
  std::uint32_t features = 0;  // of the query that are like one of its features
  bool operator==(const Place&) const = default;
};

struct PlaceIndexConfig {
  std::size_t budget_bytes = 32u << 20;  // at least 4 MB
  std::int32_t max_distance = 48;        // bits that may differ between two features that are alike
  bool simd = true;                      // false: the plain reference, which gives the same votes
};

// Which keyframes look like this one? Multi-index hashing (Norouzi, Punjani, Fleet 2012): a feature's 256 bits are
// looked up in eight tables, each by a few of its bits, and what is found there is compared in full. Each keyframe that
// has a feature like it gets a vote: the more, the fewer keyframes have one, and the nearer it is. Votes are integers
// and ties go by id, so the answer is a function of what the index holds and not of the order in which it came.
//
// Memory is taken in the constructor and is about 80 bytes a feature. A bucket holds at most 255 features, so that one
// dull wall does not slow every query down: which of more stay is decided by a hash of their ids (crowded_out() counts
// the others; they do not come back when one that stayed is removed). Used by one thread.
class PlaceIndex {
 public:
  explicit PlaceIndex(const PlaceIndexConfig& config);

  // Features in a kind's bits. False, and counted in refused(): it is there already, or there is no room for all of it.
  bool insert(const PlaceId& id, DescriptorKind kind, std::span<const BinaryFeature> features);
  bool has_room(std::size_t features) const;  // for one keyframe more, with so many
  bool remove(const PlaceId& id);             // false: it was not there
  void clear();                               // counters stay

  // At most k keyframes of this kind, most votes first, of those that pass the filter (it is asked once for each); the
  // rarity of a feature is counted among these, too.
  using Filter = std::function<bool(const PlaceId&)>;
  std::vector<Place> query(
      DescriptorKind kind, std::span<const BinaryFeature> features, std::size_t k,
      const Filter& filter = [](const PlaceId&) { return true; });

  std::size_t keyframes() const { return slots_.size(); }
  std::size_t capacity() const { return entries_.size(); }  // in features
  std::size_t used() const { return used_; }
  std::size_t table_bits() const { return table_bits_; }
  std::uint64_t refused() const { return refused_; }          // keyframes
  std::uint64_t crowded_out() const { return crowded_out_; }  // features, for each table in which they are not found
  std::size_t bytes() const;

  static constexpr std::size_t kTables = 8, kMaxBucket = 255;
  struct Entry {  // one cache line: what a query looks at
    DescriptorBits bits;
    std::array<std::uint32_t, kTables> next;  // in its bucket of each table; here and below an index plus one, 0: none
  };

 private:
  struct Owner {
    std::uint32_t keyframe;  // slot
    std::uint32_t sibling;   // next feature of the keyframe, or next free one
    std::uint16_t ordinal;   // within the keyframe
    std::int8_t laplacian;
  };
  struct Keyframe {
    PlaceId id;
    DescriptorKind kind = DescriptorKind::surf_bits;
    std::uint32_t features = 0;  // the first
    std::uint64_t hash = 0;      // of the id
  };
  struct Tally {  // of a keyframe during a query
    bool asked = false;
    std::uint8_t nearest = 255;  // distance of the feature that is looked up
    std::uint64_t votes = 0;
    std::uint32_t features = 0;
  };
  std::size_t bucket(std::size_t table, const DescriptorBits& bits) const;
  std::uint32_t take_entry();
  void link(std::size_t table, std::uint32_t entry);
  void unlink(std::size_t table, std::uint32_t entry);
  std::uint64_t precedence(std::uint32_t entry) const;
  std::size_t ask(DescriptorKind kind, const Filter& filter);
  void vote(const BinaryFeature& feature, std::uint32_t log_of_all);
  std::vector<Place> ranked(std::size_t k) const;

  template <class T>
  using Zeroed = std::vector<T, ZeroedAllocator<T>>;
  PlaceIndexConfig config_;
  std::size_t table_bits_;
  Zeroed<std::uint32_t> heads_;  // [table][bucket]
  Zeroed<std::uint8_t> counts_;
  Zeroed<Entry> entries_;
  Zeroed<Owner> owners_;
  std::uint32_t free_ = 0, untouched_ = 0;  // entries: given back, never used
  std::size_t used_ = 0, max_keyframes_;
  std::vector<Keyframe> keyframes_;
  std::vector<std::uint32_t> free_keyframes_;
  std::map<PlaceId, std::uint32_t> slots_;
  std::vector<Tally> tallies_;       // of each slot
  std::vector<std::uint32_t> near_;  // slots with a feature like the one that is looked up
  std::uint64_t refused_ = 0, crowded_out_ = 0;
};

}  // namespace onemap::mapping
