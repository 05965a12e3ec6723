#include "comms/frontier.hpp"

#include <xxhash.h>

#include <array>

#include "hal/base/bytes.hpp"

namespace onemap::comms {

namespace {
constexpr std::size_t kEntryBytes = 16 + 1 + 8 + 4;
}  // namespace

std::uint64_t entry_digest(const LogId& log, std::uint32_t count) {
  if (count == 0) return 0;  // an empty log and an unknown log are the same
  std::array<std::uint8_t, kEntryBytes> entry;
  std::uint8_t* at = entry.data();
  for (auto byte : log.robot.bytes) *at++ = byte;
  *at++ = log.lane;
  at = put_little_endian(at, log.incarnation);
  put_little_endian(at, count);
  return XXH3_64bits(entry.data(), entry.size());
}

std::uint64_t digest(const VersionVector& frontier) {
  std::uint64_t sum = 0;
  for (const auto& [log, count] : frontier) sum += entry_digest(log, count);
  return sum;
}

}  // namespace onemap::comms
