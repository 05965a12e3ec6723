#pragma once
#include <dlfcn.h>

namespace onemap::test {

// Whether umockdev-wrapper is around this process: its library is in it, not only named in LD_PRELOAD.
inline bool inside_umockdev() { return dlopen("libumockdev-preload.so.0", RTLD_LAZY | RTLD_NOLOAD) != nullptr; }

}  // namespace onemap::test
