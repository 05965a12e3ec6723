#pragma once
#include <cstdint>

namespace onemap::test {

// How often this process has called operator new so far: a program that links count_allocations.cpp counts.
std::uint64_t allocations();

}  // namespace onemap::test
