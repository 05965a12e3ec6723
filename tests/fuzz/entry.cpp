// libFuzzer's way into one target: ONEMAP_FUZZ_TARGET.
#include <cstddef>
#include <cstdint>

#include "fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  onemap::fuzz::ONEMAP_FUZZ_TARGET({data, size});
  return 0;
}
