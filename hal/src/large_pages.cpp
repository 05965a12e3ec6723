#include "hal/base/large_pages.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>

namespace onemap {

void want_large_pages(void* memory, std::size_t bytes) {
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t before = (page - address % page) % page;
  if (bytes <= before) return;
  (void)madvise(static_cast<std::byte*>(memory) + before, bytes - before, MADV_HUGEPAGE);
}

}  // namespace onemap
