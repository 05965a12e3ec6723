#include "daemon/snapshot_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "daemon/outputs.hpp"

namespace onemap::daemon {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kDigits = 6;

bool is_number(const std::string& name) {
  return name.size() >= kDigits && name.size() < 19 &&
         std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; });
}

std::uint64_t bytes_of(const fs::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code code;
  for (fs::recursive_directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    std::error_code none;
    const auto size = it->is_regular_file(none) ? it->file_size(none) : 0;
    if (!none) bytes += size;
  }
  return bytes;
}

}  // namespace

std::vector<std::string> SnapshotFolder::finished() const {
  std::vector<std::string> names;
  std::error_code code;
  for (fs::directory_iterator it(root_, code), end; !code && it != end; it.increment(code))
    if (std::string name = it->path().filename().string(); is_number(name)) names.push_back(std::move(name));
  std::ranges::sort(names, {}, [](const std::string& name) { return std::stoull(name); });
  return names;
}

Result<std::string> SnapshotFolder::begin() {
  give_up();
  if (auto made = make_folder(partial()); !made) return made.error();
  return partial();
}

void SnapshotFolder::give_up() {
  std::error_code none;
  fs::remove_all(partial(), none);
}

void SnapshotFolder::make_room(std::uint64_t bytes) {
  std::vector<std::string> names = finished();
  std::uint64_t all = bytes;
  for (const std::string& name : names) all += bytes_of(root_ + "/" + name);
  for (std::size_t i = 0; i < names.size() && (names.size() - i >= keep_ || all > limit_bytes_); ++i) {
    std::error_code none;
    all -= std::min(all, bytes_of(root_ + "/" + names[i]));
    fs::remove_all(root_ + "/" + names[i], none);
    ++removed_;
  }
}

Result<std::string> SnapshotFolder::publish() {
  const std::uint64_t bytes = bytes_of(partial());
  if (bytes > limit_bytes_) {
    give_up();
    return Error{root_, fmt::format("a snapshot of {} MB is larger than snapshots.disk_limit_mb", bytes >> 20)};
  }
  const std::vector<std::string> names = finished();
  const std::string name = fmt::format("{:06}", names.empty() ? 1 : std::stoull(names.back()) + 1);
  make_room(bytes);
  std::error_code code;
  fs::rename(partial(), root_ + "/" + name, code);
  if (code) {
    give_up();
    return Error{root_ + "/" + name, "cannot put in place: " + code.message()};
  }
  fs::remove(root_ + "/.latest", code);
  fs::create_directory_symlink(name, root_ + "/.latest", code);
  fs::rename(root_ + "/.latest", root_ + "/latest", code);  // some disks have no links; the number says it, too
  return root_ + "/" + name;
}

}  // namespace onemap::daemon
