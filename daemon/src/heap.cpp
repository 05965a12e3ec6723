#include "daemon/heap.hpp"

#include <malloc.h>

namespace onemap::daemon {

void give_memory_back() {
  constexpr int kArenas = 2, kOwnBlock = 512 << 10, kFreeTop = 1 << 20;
  // Each only ever fails for a value that makes no sense.
  (void)mallopt(M_ARENA_MAX, kArenas);
  (void)mallopt(M_MMAP_THRESHOLD, kOwnBlock);
  (void)mallopt(M_TRIM_THRESHOLD, kFreeTop);
}

}  // namespace onemap::daemon
