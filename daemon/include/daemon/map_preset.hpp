#pragma once
#include <string>

#include "daemon/config.hpp"

namespace onemap::daemon {

// What map.preset says: of the keys that a preset has values for, those with their default get the preset's, so that a
// file that says every key (--help-config) can say a preset, too. Their origin is then map.preset. To be called once,
// when all files and the command line were read.
void apply_preset(Config& config);

// "voxel_m 0.01, ...": what the preset for models to be shown sets.
std::string fine_values();

}  // namespace onemap::daemon
