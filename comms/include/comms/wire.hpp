#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "comms/wire/frames.hpp"
#include "comms/wire/header.hpp"
#include "hal/base/bytes.hpp"

// The bytes of protocol version 1 (comms/PROTOCOL.md): a datagram is a header and a sequence of frames.
namespace onemap::comms::wire {

// Reads one datagram, all or nothing: Refusal::count when it is good, else why not, and then nothing may be used.
// Frames are valid until the next decode and as long as the datagram's bytes are.
class Decoder {
 public:
  Refusal decode(std::span<const std::uint8_t> datagram);
  // The same of frames that came sealed: `header` is what a plain datagram would have said.
  Refusal decode(const Header& header, std::span<const std::uint8_t> frames);
  const Header& header() const { return header_; }
  std::span<const Frame> frames() const { return frames_; }

 private:
  void clear();
  Refusal decode_frames(std::span<const std::uint8_t> frames);
  bool decode_frame(std::uint8_t type, std::span<const std::uint8_t> body);
  bool decode_status(std::span<const std::uint8_t> body);
  bool decode_have(std::span<const std::uint8_t> body);
  bool decode_want(std::span<const std::uint8_t> body);
  bool decode_data(std::span<const std::uint8_t> body);
  bool decode_mass(std::span<const std::uint8_t> body);
  bool decode_head(std::span<const std::uint8_t> body);
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
  std::size_t room() const { return kHeaderBytes + max_frames_ - size_; }

  bool beacon(const Beacon& beacon);
  std::size_t status(std::span<const RobotStatus> robots);
  std::size_t have(std::uint64_t frontier_digest, std::span<const HaveEntry> entries);
  bool have_request();
  std::size_t want(std::uint32_t credit_bytes, std::span<const WantEntry> entries);
  bool data(const Data& data);
  bool head(const Head& head);
  bool ping(std::uint32_t token);
  bool pong(std::uint32_t token);
  bool feedback(const Feedback& feedback);
  bool later_life(const LaterLife& later);
  bool mass(const Mass& mass);

 private:
  bool open(FrameType type, std::size_t body_bytes);
  std::size_t entries_that_fit(std::size_t fixed, std::size_t each, std::size_t wanted) const;
  template <std::integral T>
  void put(T value) {
    put_little_endian(&buffer_[size_], value);
    size_ += sizeof(T);
  }
  template <std::size_t N>
  void put(const std::array<std::uint8_t, N>& bytes) {
    for (auto byte : bytes) put(byte);
  }
  void put(const RobotId& robot);
  void put(const LogId& log);
  std::span<std::uint8_t, kMaxDatagramBytes> buffer_;
  std::size_t max_frames_;
  std::size_t size_ = kHeaderBytes;
};

}  // namespace onemap::comms::wire
