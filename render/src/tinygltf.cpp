// The one place where tinygltf's code is compiled: header-only and without its image codecs, so that no program needs a
// shared library for it.
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#include "tinygltf.hpp"
