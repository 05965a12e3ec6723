#pragma once

// A hot loop and its twin: one body, compiled once for the baseline CPU (NAME_plain) and once for AVX2 (NAME_simd),
// which the caller chooses at run time (simd_available). The body holds integers, or floats without reassociation, so
// both give the same bits.
#define ONEMAP_TWIN_BODY [[gnu::always_inline]] inline
#if defined(__x86_64__)
#define ONEMAP_TARGET_AVX2 [[gnu::target("avx2")]]
#else
#define ONEMAP_TARGET_AVX2
#endif
#define ONEMAP_TWIN(name, parameters, arguments)          \
  void name##_plain parameters { name##_body arguments; } \
  ONEMAP_TARGET_AVX2 void name##_simd parameters { name##_body arguments; }

namespace onemap {

inline bool simd_available() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

}  // namespace onemap
