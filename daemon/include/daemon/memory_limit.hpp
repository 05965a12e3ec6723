#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "daemon/config.hpp"

namespace onemap::daemon {

// How much memory this process can have at most, and what says so.
struct MemoryLimit {
  std::uint64_t bytes = UINT64_MAX;
  std::string what = "nothing";
};

// The least of: the machine's memory, the limits of the control groups (versions 1 and 2) that the process is in, and
// its own limit of address space. What cannot be read limits nothing. root: of the file systems, for tests.
MemoryLimit memory_limit(const std::filesystem::path& root = "/");

// Whether all budgets together fit, and once the camera is known the frames that it fills; the error says each and the
// sum.
Status check_memory(const Config& config, const MemoryLimit& limit, std::uint64_t frame_bytes = 0);

}  // namespace onemap::daemon
