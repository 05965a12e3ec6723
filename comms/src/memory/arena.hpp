#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>

namespace onemap::comms {

// One block of memory, taken at the start, in which everything that a Node remembers lives: two-level segregated fit
// (Masmano, Ripoll, Crespo and Real, 2004), so that taking and giving back cost the same at any time, and what is given
// back joins its free neighbours. 8 bytes a piece, at least 16 in all.
//
// The standard library's pools would do, if what one size was given could ever be had by another, and large pieces
// could be given back to a fixed block: over hours records of all sizes come and go.
//
// When nothing fits, the heap gives it, and that is counted: limits elsewhere are such that it does not happen.
class Arena final : public std::pmr::memory_resource {
 public:
  // touched: its pages are taken now, and not as they are used. Throws std::bad_alloc when there is no such block.
  explicit Arena(std::size_t bytes, bool touched = false);
  ~Arena() override;
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  std::size_t capacity() const { return std::size_t{units_} * kUnit; }
  std::size_t used() const { return used_; }  // bytes, what each piece takes beside itself included
  std::size_t most_used() const { return most_; }
  std::uint64_t spilled() const { return spilled_; }  // pieces that the heap gave

 private:
  static constexpr std::size_t kUnit = 16, kHeadBytes = 8;
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  static constexpr unsigned kSecondBits = 4, kSecond = 1u << kSecondBits, kFirst = 28;
  // Places and sizes in units. A block's head stands in the last 8 bytes of the unit before its first whole one.
  struct Head {
    std::uint32_t before;  // where the block before it begins; kNone: it is the first
    std::uint32_t size : 31, free : 1;
  };
  struct Links {  // of a free block, in its first bytes
    std::uint32_t next, previous;
  };
  struct Class {
    unsigned first, second;
  };
  static Class class_of(std::uint32_t size);
  Head& head(std::uint32_t block);
  Links& links(std::uint32_t block);
  std::byte* payload(std::uint32_t block);
  void insert(std::uint32_t block);
  void remove(std::uint32_t block);
  std::uint32_t find(std::uint32_t size);
  void split(std::uint32_t block, std::uint32_t size);
  void release(std::uint32_t block);
  void open(std::uint32_t block);   // its head and links may be used
  void close(std::uint32_t block);  // and nothing else of it: a sanitizer says so

  void* do_allocate(std::size_t bytes, std::size_t alignment) override;
  void do_deallocate(void* piece, std::size_t bytes, std::size_t alignment) override;
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }

  std::byte* base_ = nullptr;
  std::uint32_t units_ = 0;
  std::uint32_t first_map_ = 0;
  std::array<std::uint32_t, kFirst> second_map_{};
  std::array<std::array<std::uint32_t, kSecond>, kFirst> lists_{};
  std::size_t used_ = 0, most_ = 0;
  std::uint64_t spilled_ = 0;
};

}  // namespace onemap::comms
