#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "comms/counters.hpp"
#include "comms/datagram_port.hpp"
#include "comms/status.hpp"
#include "hal/base/record.hpp"

// The bytes of protocol version 1 (comms/PROTOCOL.md): a datagram is a header and a sequence of frames. A secure
// session will replace the header and wrap the frames; the frames stay.
namespace onemap::comms::wire {

inline constexpr std::uint8_t kMagicAndVersion = 0xB1;  // high nibble: ours; low nibble: major version
inline constexpr std::size_t kHeaderBytes = 24;
inline constexpr std::size_t kMaxFramesBytes = 1168;  // what a session's overhead of 32 bytes will leave
inline constexpr std::size_t kFrameHeadBytes = 3;
inline constexpr std::size_t kFragmentBytes = 1112;  // of a record's body; only the last fragment is shorter
inline constexpr std::uint8_t kFirstSkippableType = 128;
inline constexpr std::uint64_t kFirstBadIncarnation = std::uint64_t{1}
                                                      << 63;  // no life has this number or a greater one
inline constexpr bool is_life(std::uint64_t incarnation) {
  return incarnation != 0 && incarnation < kFirstBadIncarnation;
}
inline constexpr std::uint32_t next_counter(std::uint32_t counter) { return counter == 0xFFFFFFFF ? 1 : counter + 1; }

enum class DatagramType : std::uint8_t { unicast = 8, group = 9 };

struct Header {
  DatagramType type = DatagramType::unicast;
  std::uint64_t sender = 0;    // the sender's incarnation
  std::uint64_t receiver = 0;  // the receiver's incarnation as the sender knows it; 0: not known, or a group
  // 1, 2, 3 ... by the sender, one count for each destination; after 2^32 - 1 comes 1.
  std::uint32_t counter = 0;
  bool operator==(const Header&) const = default;
};

struct Beacon {
  RobotId robot;
  std::uint64_t frontier_digest = 0, map_digest = 0;
  std::uint32_t status_counter = 0;
  std::uint8_t flags = 0;
  bool operator==(const Beacon&) const = default;
};
struct HaveEntry {
  LogId log;
  std::uint32_t count = 0;  // at least 1
  bool operator==(const HaveEntry&) const = default;
};
struct WantEntry {
  RecordId id;
  std::uint16_t first = 0, count = 0;  // fragments; what lies behind the record's end is not meant
  bool operator==(const WantEntry&) const = default;
};

// Decoded frames. The spans point into the decoder's own lists or into the datagram.
struct Status {
  std::span<const RobotStatus> robots;
};
struct Have {
  std::uint64_t frontier_digest = 0;  // of all that the sender holds, not only of these entries
  std::span<const HaveEntry> entries;
};
struct HaveRequest {};
struct Want {
  std::uint32_t credit_bytes = 0;  // how much may wait for the asker at the server, these entries included
  std::span<const WantEntry> entries;
};
struct Data {
  RecordId id;
  std::uint16_t kind = 0;
  std::uint8_t hops = 0;  // links that the sender's copy came over
  std::uint32_t total_bytes = 0;
  std::uint64_t body_hash = 0;  // body_hash(kind, body)
  std::uint16_t fragment = 0;
  std::span<const std::uint8_t> bytes;
};
struct Ping {
  std::uint32_t token = 0;
};
struct Pong {
  std::uint32_t token = 0;
};
// Somebody who holds records of a later life of `robot` tells it so.
struct LaterLife {
  RobotId robot;
  std::uint64_t incarnation = 0;
  bool operator==(const LaterLife&) const = default;
};
using Frame = std::variant<Beacon, Status, Have, HaveRequest, Want, Data, Ping, Pong, LaterLife>;
FrameType type_of(const Frame& frame);

inline constexpr std::size_t kBeaconBytes = 37;
inline constexpr std::size_t kStatusEntryBytes = 45;
inline constexpr std::size_t kHaveEntryBytes = 29, kHaveFixedBytes = 8;
inline constexpr std::size_t kWantEntryBytes = 33, kWantFixedBytes = 4;
inline constexpr std::size_t kDataFixedBytes = 46;
inline constexpr std::size_t kLaterLifeBytes = 24;

inline constexpr std::uint32_t fragments_of(std::uint32_t total_bytes) {
  return std::max<std::uint32_t>(1, (total_bytes + kFragmentBytes - 1) / kFragmentBytes);
}
// XXH3-64 of the body with the kind as the seed.
std::uint64_t body_hash(std::uint16_t kind, std::span<const std::uint8_t> body);

// Reads one datagram, all or nothing: Refusal::count when it is good, else why not, and then nothing may be used.
// Frames are valid until the next decode and as long as the datagram's bytes are.
class Decoder {
 public:
  Refusal decode(std::span<const std::uint8_t> datagram);
  const Header& header() const { return header_; }
  std::span<const Frame> frames() const { return frames_; }

 private:
  Refusal decode_frames(std::span<const std::uint8_t> frames);
  bool decode_frame(std::uint8_t type, std::span<const std::uint8_t> body);
  bool decode_status(std::span<const std::uint8_t> body);
  bool decode_have(std::span<const std::uint8_t> body);
  bool decode_want(std::span<const std::uint8_t> body);
  bool decode_data(std::span<const std::uint8_t> body);
  bool valid(const RobotId& robot);
  bool valid(const LogId& log);
  Header header_;
  bool bad_robot_id_ = false;  // why decode_frame answered false
  std::vector<Frame> frames_;
  // Room for the largest lists that fit a datagram, reserved once: the frames' spans point in here.
  std::vector<RobotStatus> robots_;
  std::vector<HaveEntry> have_;
  std::vector<WantEntry> want_;
};

// Writes one datagram into a fixed buffer. Each call writes a whole frame or nothing; list frames write as many entries
// as fit and answer how many.
class Encoder {
 public:
  Encoder(std::span<std::uint8_t, kMaxDatagramBytes> buffer, const Header& header);
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == kHeaderBytes; }
  std::size_t room() const { return kHeaderBytes + kMaxFramesBytes - size_; }

  bool beacon(const Beacon& beacon);
  std::size_t status(std::span<const RobotStatus> robots);
  std::size_t have(std::uint64_t frontier_digest, std::span<const HaveEntry> entries);
  bool have_request();
  std::size_t want(std::uint32_t credit_bytes, std::span<const WantEntry> entries);
  bool data(const Data& data);
  bool ping(std::uint32_t token);
  bool pong(std::uint32_t token);
  bool later_life(const LaterLife& later);

 private:
  bool open(FrameType type, std::size_t body_bytes);
  std::size_t entries_that_fit(std::size_t fixed, std::size_t each, std::size_t wanted) const;
  template <class T>
  void put(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) buffer_[size_++] = static_cast<std::uint8_t>(value >> (8 * i));
  }
  void put(const RobotId& robot);
  void put(const LogId& log);
  std::span<std::uint8_t, kMaxDatagramBytes> buffer_;
  std::size_t size_ = 0;
};

}  // namespace onemap::comms::wire
