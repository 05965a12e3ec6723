#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "hal/base/time.hpp"

namespace onemap::comms::sim {

// The air that neighbours share: who sends takes time from all who hear it, and who hears somebody else waits.
class Medium {
 public:
  struct Model {
    std::uint64_t bytes_per_second = 0;                  // 0: there is enough for everybody
    std::size_t overhead_bytes = 0;                      // of a datagram, for what stands before it on the air
    Duration patience = std::chrono::milliseconds(200);  // what would wait longer is dropped
  };
  explicit Medium(Model model) : model_(model) {}
  Medium() : Medium(Model{}) {}

  using Hears = std::function<bool(std::size_t listener)>;
  // When a datagram has left; nothing: it is dropped.
  std::optional<Instant> send(Instant now, std::size_t from, std::size_t robots, std::size_t bytes, const Hears& hears);
  const Model& model() const { return model_; }
  Duration cost(std::size_t bytes) const;

 private:
  Model model_;
  std::vector<Instant> busy_until_;  // around each robot
};

}  // namespace onemap::comms::sim
