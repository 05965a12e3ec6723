#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

// The last settled map of a robot in its state folder, so that it outlives the daemon and the machine's power. The map
// (the bytes of save_map) is map-DIGEST.omap; settled-map says which one counts, how long it is and what it sums up to.
// Both are written whole or not at all, the map first: after a crash there is the old one or the new one. For one
// thread.
class KeptMap {
 public:
  explicit KeptMap(std::string folder) : folder_(std::move(folder)) {}

  struct Kept {
    std::string file;
    std::uint64_t digest = 0;  // of the map, as everywhere
  };
  // At the start: what an earlier life left, if it is whole. What is not is set aside, and the error says as what;
  // nothing at all is no error.
  Result<std::optional<Kept>> open();

  // Whether this map should be kept now: it is settled, another one than is kept, and the last was written a while ago.
  bool due(std::uint64_t digest, bool settled, Instant now) const;
  void trying(Instant now) { tried_at_ = now; }  // whatever becomes of it, the next due() is a while away
  // An error leaves the one before in place.
  Status keep(std::uint64_t digest, std::span<const std::uint8_t> map, Instant now);
  const std::optional<Kept>& kept() const { return kept_; }

 private:
  Error spoilt(const std::string& file, const std::string& reason) const;
  void remove_others() const;
  const std::string folder_;
  std::optional<Kept> kept_;
  std::optional<Instant> tried_at_;
};

}  // namespace onemap::daemon
