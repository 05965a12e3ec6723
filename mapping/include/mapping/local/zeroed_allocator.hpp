#pragma once
#include <algorithm>
#include <cstdlib>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#include "hal/base/large_pages.hpp"

namespace onemap::mapping {

// For large arrays whose elements are all zero bits when new: memory comes zeroed and elements without a value are not
// written, so the system gives each page only when something is stored in it.
template <class T>
struct ZeroedAllocator {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
  using value_type = T;
  ZeroedAllocator() = default;
  template <class U>
  explicit ZeroedAllocator(const ZeroedAllocator<U>&) {}

  T* allocate(std::size_t count) {
    void* memory = std::calloc(count, sizeof(T));
    if (memory == nullptr) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t) { std::free(memory); }
  void construct(T*) {}
  template <class... Args>
  void construct(T* place, Args&&... args) {
    ::new (static_cast<void*>(place)) T(std::forward<Args>(args)...);
  }
  bool operator==(const ZeroedAllocator&) const { return true; }
};

// Every page of a new array is given now, and none later.
template <class T>
void make_resident(std::vector<T, ZeroedAllocator<T>>& array) {
  want_large_pages(array.data(), array.size() * sizeof(T));
  std::fill(array.begin(), array.end(), T{});
}

}  // namespace onemap::mapping
