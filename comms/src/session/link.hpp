#pragma once
#include <cstdint>
#include <optional>

#include "comms/endpoint.hpp"
#include "session/initiation.hpp"
#include "session/transport.hpp"

namespace onemap::comms {

// All that a Guard has with one address.
struct Link {
  std::optional<Transport> current, previous;  // the previous one takes what is still on its way
  std::optional<Initiation> initiation;
  unsigned attempts = 0;          // in vain, in a row
  Instant not_before{};           // no handshake is begun earlier
  Instant met_again{};            // the last one that was begun because there a session is spoken that is not here
  std::size_t unknown_bytes = 0;  // of such sessions came since
  Instant wanted{};               // the node had something for there that no session could carry
  Instant spoke{};                // a datagram was sealed
  Instant heard{};                // an authentic one came
  std::optional<Mac> cookie;
  Instant cookie_until{};
  Mac proof_mac{};  // of the proof that made the current session
  struct Move {     // to where its datagrams come from lately, once that address has answered
    Endpoint to;
    std::uint64_t token = 0;
    Instant asked{};
  };
  std::optional<Move> move;

  Transport* of(std::uint32_t index) {
    if (current && current->own_index() == index) return &*current;
    if (previous && previous->own_index() == index) return &*previous;
    if (initiation && initiation->made() && initiation->index() == index) return &*initiation->made();
    return nullptr;
  }
};

}  // namespace onemap::comms
