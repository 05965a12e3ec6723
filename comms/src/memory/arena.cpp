#include "memory/arena.hpp"

#include <algorithm>
#include <bit>
#include <functional>
#include <new>

#include "memory/memory.hpp"

// A sanitizer is told what may be used; its header comes with it, and is not everywhere.
#if defined(__SANITIZE_ADDRESS__)
#define ONEMAP_ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define ONEMAP_ADDRESS_SANITIZER
#endif
#endif
#ifdef ONEMAP_ADDRESS_SANITIZER
#include <sanitizer/asan_interface.h>
#endif

namespace onemap::comms {

namespace {
#ifdef ONEMAP_ADDRESS_SANITIZER
void forbid(const std::byte* from, std::size_t bytes) { ASAN_POISON_MEMORY_REGION(from, bytes); }
void allow(const std::byte* from, std::size_t bytes) { ASAN_UNPOISON_MEMORY_REGION(from, bytes); }
#else
void forbid(const std::byte*, std::size_t) {}
void allow(const std::byte*, std::size_t) {}
#endif
}  // namespace

Arena::Arena(std::size_t bytes, bool touched) : units_(static_cast<std::uint32_t>(bytes / kUnit)) {
  static_assert(sizeof(Head) == kHeadBytes && sizeof(Links) <= kUnit - kHeadBytes);
  if (bytes / kUnit < 4 || bytes / kUnit >= 1u << kFirst) throw std::bad_alloc();
  base_ = static_cast<std::byte*>(heap().allocate(capacity(), kUnit));
  if (touched) std::fill_n(base_, capacity(), std::byte{});
  for (auto& list : lists_) list.fill(kNone);
  // The unit before the first block has its head, and the last one that of a block of nothing, which is never free.
  const std::uint32_t end = units_ - 2;
  head(0) = {kNone, end, 0};
  head(end) = {0, 0, 0};
  close(0);
  insert(0);
}

Arena::~Arena() {
  allow(base_, capacity());
  heap().deallocate(base_, capacity(), kUnit);
}

void Arena::open(std::uint32_t block) { allow(payload(block) - kHeadBytes, kHeadBytes + sizeof(Links)); }

void Arena::close(std::uint32_t block) {
  forbid(payload(block) + sizeof(Links), head(block).size * kUnit - kHeadBytes - sizeof(Links));
}

// Classes of sizes: each power of two in sixteen equal parts, and sizes below sixteen by themselves.
Arena::Class Arena::class_of(std::uint32_t size) {
  if (size < kSecond) return {0, size};
  const auto power = static_cast<unsigned>(std::bit_width(size)) - 1;
  return {power - kSecondBits + 1, (size >> (power - kSecondBits)) - kSecond};
}

std::byte* Arena::payload(std::uint32_t block) { return base_ + (std::size_t{block} + 1) * kUnit; }
Arena::Head& Arena::head(std::uint32_t block) { return *reinterpret_cast<Head*>(payload(block) - kHeadBytes); }
Arena::Links& Arena::links(std::uint32_t block) { return *reinterpret_cast<Links*>(payload(block)); }

void Arena::insert(std::uint32_t block) {
  const Class c = class_of(head(block).size);
  std::uint32_t& first = lists_[c.first][c.second];
  links(block) = {first, kNone};
  if (first != kNone) links(first).previous = block;
  first = block;
  head(block).free = 1;
  first_map_ |= 1u << c.first;
  second_map_[c.first] |= 1u << c.second;
}

void Arena::remove(std::uint32_t block) {
  const Class c = class_of(head(block).size);
  const Links at = links(block);
  if (at.next != kNone) links(at.next).previous = at.previous;
  if (at.previous != kNone)
    links(at.previous).next = at.next;
  else
    lists_[c.first][c.second] = at.next;
  head(block).free = 0;
  if (lists_[c.first][c.second] != kNone) return;
  second_map_[c.first] &= ~(1u << c.second);
  if (second_map_[c.first] == 0) first_map_ &= ~(1u << c.first);
}

// A block of a class whose least one is large enough.
std::uint32_t Arena::find(std::uint32_t size) {
  if (size >= kSecond) size += (1u << (static_cast<unsigned>(std::bit_width(size)) - 1 - kSecondBits)) - 1;
  Class c = class_of(size);
  std::uint32_t second = c.first < kFirst ? second_map_[c.first] & (~0u << c.second) : 0;
  if (second == 0) {
    const std::uint32_t first = c.first + 1 < kFirst ? first_map_ & (~0u << (c.first + 1)) : 0;
    if (first == 0) return kNone;
    c.first = static_cast<unsigned>(std::countr_zero(first));
    second = second_map_[c.first];
  }
  return lists_[c.first][static_cast<unsigned>(std::countr_zero(second))];
}

void Arena::split(std::uint32_t block, std::uint32_t size) {
  const std::uint32_t rest = head(block).size - size;
  if (rest == 0) return;
  const std::uint32_t behind = block + size;
  head(block).size = size;
  open(behind);
  head(behind) = {block, rest, 0};
  head(behind + rest).before = behind;
  insert(behind);
}

void Arena::release(std::uint32_t block) {
  const std::uint32_t next = block + head(block).size;
  if (head(next).free != 0) {
    remove(next);
    head(block).size += head(next).size;
  }
  if (const std::uint32_t before = head(block).before; before != kNone && head(before).free != 0) {
    remove(before);
    head(before).size += head(block).size;
    block = before;
  }
  head(block + head(block).size).before = block;
  insert(block);
}

void* Arena::do_allocate(std::size_t bytes, std::size_t alignment) {
  const std::size_t units = (std::max<std::size_t>(bytes, 1) + kHeadBytes + kUnit - 1) / kUnit;
  const std::uint32_t block = alignment <= kUnit && units < units_ ? find(static_cast<std::uint32_t>(units)) : kNone;
  if (block == kNone) {
    ++spilled_;
    return heap().allocate(bytes, alignment);
  }
  remove(block);
  split(block, static_cast<std::uint32_t>(units));
  used_ += units * kUnit;
  most_ = std::max(most_, used_);
  allow(payload(block), bytes);
  return payload(block);
}

void Arena::do_deallocate(void* piece, std::size_t bytes, std::size_t alignment) {
  auto* const at = static_cast<std::byte*>(piece);
  const std::less<const std::byte*> before;
  if (before(at, base_) || !before(at, base_ + capacity())) return heap().deallocate(piece, bytes, alignment);
  const auto block = static_cast<std::uint32_t>((at - base_) / static_cast<std::ptrdiff_t>(kUnit)) - 1;
  used_ -= std::size_t{head(block).size} * kUnit;
  close(block);
  release(block);
}

}  // namespace onemap::comms
