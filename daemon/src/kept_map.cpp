#include "daemon/kept_map.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>

#include "daemon/set_aside.hpp"
#include "hal/base/file.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace onemap::daemon {

namespace {

namespace fs = std::filesystem;
constexpr auto kInterval = std::chrono::seconds(30);  // a map that changes all the time does not wear out the disk
constexpr const char* kPointer = "/settled-map";

struct Pointer {
  std::uint64_t digest = 0, bytes = 0, sum = 0;
};

std::uint64_t sum_of(std::span<const std::uint8_t> bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string name_of(std::uint64_t digest) { return fmt::format("/map-{:016x}.omap", digest); }

std::string to_text(const Pointer& p) { return fmt::format("{:016x} {} {:016x}\n", p.digest, p.bytes, p.sum); }

// Exactly what to_text() writes, or nothing.
std::optional<Pointer> pointer_from(const std::string& text) {
  Pointer p;
  std::istringstream in(text);
  in >> std::hex >> p.digest >> std::dec >> p.bytes >> std::hex >> p.sum;
  return in && to_text(p) == text ? std::optional(p) : std::nullopt;
}

}  // namespace

Error KeptMap::spoilt(const std::string& file, const std::string& reason) const {
  const auto aside = set_aside(file);
  return {file, reason + (aside ? "; set aside as " + *aside : "; " + aside.error().reason)};
}

Result<std::optional<KeptMap::Kept>> KeptMap::open() {
  kept_.reset();
  const std::string file = folder_ + kPointer;
  std::error_code none;
  if (!fs::exists(file, none)) return kept_;
  const auto text = read_text_file(file, kSmallFileBytes);
  const auto pointer = text ? pointer_from(*text) : std::nullopt;
  if (!pointer) return spoilt(file, text ? "does not say which map is kept" : text.error().reason);
  const std::string map = folder_ + name_of(pointer->digest);
  const auto bytes = read_file(map);
  if (!bytes) {
    spoilt(file, "");  // it points to nothing
    return bytes.error();
  }
  if (bytes->size() != pointer->bytes || sum_of(*bytes) != pointer->sum) {
    fs::remove(file, none);
    return spoilt(map, "the kept map is not the one that was written");
  }
  kept_ = {map, pointer->digest};
  remove_others();  // of a life that ended between two writes
  return kept_;
}

bool KeptMap::due(std::uint64_t digest, bool settled, Instant now) const {
  if (digest == 0 || !settled || (kept_ && kept_->digest == digest)) return false;
  return !tried_at_ || now - *tried_at_ >= kInterval;
}

Status KeptMap::keep(std::uint64_t digest, std::span<const std::uint8_t> map, Instant now) {
  trying(now);
  const std::string file = folder_ + name_of(digest);
  if (auto status = write_file(file, map); !status) return status;
  if (auto status = write_text_file(folder_ + kPointer, to_text({digest, map.size(), sum_of(map)})); !status)
    return status;
  kept_ = {file, digest};
  remove_others();
  return success();
}

void KeptMap::remove_others() const {
  std::error_code error;
  std::vector<fs::path> others;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const bool a_map = name.starts_with("map-") && name.ends_with(".omap");
    if (a_map && name != fs::path(kept_->file).filename()) others.push_back(entry->path());
  }
  for (const fs::path& other : others) fs::remove(other, error);
}

}  // namespace onemap::daemon
