#include "daemon/memory_limit.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <array>
#include <charconv>
#include <optional>
#include <sstream>
#include <string_view>

#include "hal/base/file.hpp"

namespace onemap::daemon {

namespace {

namespace fs = std::filesystem;

void take_least(MemoryLimit& least, std::uint64_t bytes, const std::string& what) {
  if (bytes < least.bytes) least = {bytes, what};
}

// The number that a text begins with, after blanks.
std::optional<std::uint64_t> number_at(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} ? std::optional(value) : std::nullopt;
}

// The lines of a file; none when it cannot be read.
std::istringstream lines_of(const fs::path& path) {
  auto text = read_text_file(path.string());
  return std::istringstream(text ? std::move(*text) : std::string());
}

void take_machine(const fs::path& root, MemoryLimit& least) {
  auto file = lines_of(root / "proc/meminfo");
  constexpr std::string_view kTotal = "MemTotal:";
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(kTotal))
      if (const auto kb = number_at(std::string_view(line).substr(kTotal.size())))
        take_least(least, *kb * 1024, "this machine has");
}

// A group's limit holds for the groups below it. In a container the path is often the host's and not there, and the
// container's own group is the topmost that can be seen.
void take_groups(const fs::path& top, const std::string& group, const char* file_name, MemoryLimit& least) {
  fs::path folder = top / fs::path(group).relative_path();
  for (;;) {
    auto file = lines_of(folder / file_name);
    std::string line;
    if (std::getline(file, line))
      if (const auto bytes = number_at(line)) take_least(least, *bytes, "this process's control group allows");
    if (folder == top || !folder.has_relative_path()) return;
    folder = folder.parent_path();
  }
}

// Lines are HIERARCHY:CONTROLLERS:PATH; version 2 has hierarchy 0 and no controllers.
void take_all_groups(const fs::path& root, MemoryLimit& least) {
  const fs::path top = root / "sys/fs/cgroup";
  auto file = lines_of(root / "proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = fmt::format(",{},", line.substr(first + 1, second - first - 1));
    const std::string group = line.substr(second + 1);
    if (controllers == ",,") take_groups(top, group, "memory.max", least);
    if (controllers.find(",memory,") != std::string::npos)
      take_groups(top / "memory", group, "memory.limit_in_bytes", least);
  }
}

}  // namespace

MemoryLimit memory_limit(const fs::path& root) {
  MemoryLimit least;
  take_machine(root, least);
  take_all_groups(root, least);
  rlimit space{};
  if (::getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY)
    take_least(least, space.rlim_cur, "this process's limit of address space is");
  return least;
}

// While a map is fused, one anchor's submaps are decoded beside it, before and after: each half as much as the map may
// have (MapFusion). What the local mapper's keyframes take is no key's.
Status check_memory(const Config& config, const MemoryLimit& limit, std::uint64_t frame_bytes) {
  struct Budget {
    const char* key;
    std::size_t bytes;
    unsigned times = 1;
  };
  const std::array<Budget, 5> budgets{{{"map.budget_mb", config.mapper.map.budget_bytes},
                                       {"map.global_budget_mb", config.global_budget_bytes, 2},
                                       {"map.places_budget_mb", config.places_budget_bytes},
                                       {"map.plan_budget_mb", config.plan.space.budget_bytes},
                                       {"network.store_budget_mb", config.store_budget_bytes}}};
  std::uint64_t sum = 0;
  std::string each, keys;
  for (const auto& [key, bytes, times] : budgets) {
    sum += times * bytes;
    const std::string factor = times == 1 ? "" : fmt::format("{} * ", times);
    each += fmt::format("{}{}{}", each.empty() ? "" : " + ", factor, bytes >> 20);
    keys += fmt::format("{}{}{}", keys.empty() ? "" : " + ", factor, key);
  }
  if (frame_bytes > 0) {
    sum += frame_bytes;
    each += fmt::format(" + {}", frame_bytes >> 20);
    keys += " + the camera's frames";
  }
  if (sum <= limit.bytes) return success();
  return Error{keys, fmt::format("{} = {} MB, but {} {} MB", each, sum >> 20, limit.what, limit.bytes >> 20)};
}

}  // namespace onemap::daemon
