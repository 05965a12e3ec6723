#pragma once
#include <cstdio>
#include <cstdlib>

namespace onemap::fuzz {

inline void expect(bool kept, const char* promise, const char* file, int line) {
  if (kept) return;
  std::fprintf(stderr, "%s:%d: not so: %s\n", file, line, promise);
  std::abort();
}

}  // namespace onemap::fuzz

// A promise of what is fuzzed. It ends the process in every build: the input is kept by who runs it.
#define ONEMAP_FUZZ_EXPECT(promise) ::onemap::fuzz::expect((promise), #promise, __FILE__, __LINE__)
