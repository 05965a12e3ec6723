#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/base/result.hpp"

namespace onemap::render {

// Whether a file must outlive a power cut once write_file() has returned. `no` is for what is written again in a
// moment.
enum class Durable : bool { no, yes };

// Writes a file whole or not at all: into a temporary file in the same folder, synced to the disk, then renamed over
// the old one, and the folder synced. The error's place is the path, its reason the step that failed and the system's
// words (no such directory, no space left on device, ...); the old file is then as it was (unless only the folder could
// not be synced), and the temporary one is gone. What is no regular file (a folder, a device) is never replaced.
// Several writers of one path, in one process or in many, do not disturb each other: one of them is last.
Status write_file(const std::string& path, std::span<const std::uint8_t> bytes, Durable durable = Durable::yes);

Result<std::vector<std::uint8_t>> read_file(const std::string& path);

}  // namespace onemap::render
