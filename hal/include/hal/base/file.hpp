#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/base/result.hpp"

// Whole files. Every error's place is the path, its reason the step that failed and the system's words (no such file,
// no space left on device, ...). Not for what is pure: mapping, comms and hal/imaging get bytes.
namespace onemap {

inline constexpr std::size_t kAnySize = std::numeric_limits<std::size_t>::max();
inline constexpr std::size_t kSmallFileBytes = 64 << 10;  // a calibration, a list of settings

// Bytes or text to the end of a file, a pipe or what the kernel shows as a file. Over most_bytes it is refused: it is
// not what it should be.
Result<std::vector<std::uint8_t>> read_file(const std::string& path, std::size_t most_bytes = kAnySize);
Result<std::string> read_text_file(const std::string& path, std::size_t most_bytes = kAnySize);

// The same into memory that is used again; for data, so that a pipe, on which one could wait for ever, is refused.
Status read_regular_file(const std::string& path, std::vector<std::uint8_t>& into, std::size_t most_bytes);

// Whether a file must outlive a power cut once write_file() has returned. `no` is for what is written again in a
// moment.
enum class Durable : bool { no, yes };

// Writes a file whole or not at all: into a temporary file in the same folder, synced to the disk, then renamed over
// the old one, and the folder synced. After an error the old file is as it was (unless only the folder could not be
// synced), and the temporary one is gone. What is no regular file (a folder, a device) is never replaced. Several
// writers of one path, in one process or in many, do not disturb each other: one of them is last.
Status write_file(const std::string& path, std::span<const std::uint8_t> bytes, Durable durable = Durable::yes);
Status write_text_file(const std::string& path, std::string_view text, Durable durable = Durable::yes);

}  // namespace onemap
