#include "daemon/heap.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

namespace onemap::daemon {

void give_memory_back() {
  constexpr int kArenas = 2, kOwnBlock = 12 << 10, kFreeTop = 1 << 20;
  // Each only ever fails for a value that makes no sense.
  (void)mallopt(M_ARENA_MAX, kArenas);
  (void)mallopt(M_MMAP_THRESHOLD, kOwnBlock);
  (void)mallopt(M_TRIM_THRESHOLD, kFreeTop);
}

void give_back_holes() { (void)malloc_trim(0); }

void keep_memory() {
  constexpr std::uintptr_t kHugePage = 2 << 20;
  constexpr int kRoom = 1 << 30;  // addresses, not memory
  (void)mallopt(M_MMAP_MAX, 0);
  (void)mallopt(M_TRIM_THRESHOLD, kRoom);
  (void)mallopt(M_TOP_PAD, kRoom);
  void* const more = std::malloc(kHugePage);  // the heap grows, by the room as well
  const auto from = (reinterpret_cast<std::uintptr_t>(more) + kHugePage - 1) & ~(kHugePage - 1);
  const auto to = reinterpret_cast<std::uintptr_t>(sbrk(0)) & ~(kHugePage - 1);
  std::free(more);
  // Whoever replaces malloc has no such heap, and without huge pages it is small ones, as ever.
  if (more != nullptr && from < to && to - from <= std::uintptr_t{2} * kRoom)
    (void)madvise(reinterpret_cast<void*>(from), to - from, MADV_HUGEPAGE);  // NOLINT(performance-no-int-to-ptr)
  (void)mallopt(M_TOP_PAD, kRoom / 16);
}

}  // namespace onemap::daemon
