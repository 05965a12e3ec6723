// libFuzzer's way in: clang++ -fsanitize=fuzzer,address; see tests/fuzz/README.md.
#include "fuzz/guard.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  onemap::fuzz::fuzz_guard(data, size);
  return 0;
}
