#include "hal/base/large_pages.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>

namespace onemap {

namespace {
struct Pages {
  void* first = nullptr;
  std::size_t bytes = 0;
};

std::uintptr_t page_bytes() { return static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE)); }

// What is left of it behind the first page's beginning.
Pages from_a_page(void* memory, std::size_t bytes) {
  const std::uintptr_t page = page_bytes(), before = (page - reinterpret_cast<std::uintptr_t>(memory) % page) % page;
  if (bytes <= before) return {};
  return {static_cast<std::byte*>(memory) + before, bytes - before};
}
}  // namespace

void want_large_pages(void* memory, std::size_t bytes) {
  const Pages pages = from_a_page(memory, bytes);
  if (pages.bytes > 0) (void)madvise(pages.first, pages.bytes, MADV_HUGEPAGE);
}

bool give_back_pages(void* memory, std::size_t bytes) {
  const Pages pages = from_a_page(memory, bytes);
  const std::size_t whole = pages.bytes / page_bytes() * page_bytes();
  return whole == 0 || madvise(pages.first, whole, MADV_DONTNEED) == 0;
}

}  // namespace onemap
