#pragma once
// What strangers send to a robot of a team with a key, of every kind that has a way of its own through the Guard:
// nothing of it is worth a word, and each is counted as refused.
#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>
#include <vector>

#include "session/sealed_wire.hpp"
#include "support/other_side.hpp"

namespace onemap::comms::sim {

class Garbage {
 public:
  enum class Kind { noise, other_magic, plain, cut, hello, answer, proof, cookie, group, no_session, forged, word };
  static constexpr std::array<std::pair<Kind, std::string_view>, 12> kKinds{
      {{Kind::noise, "noise"},              // random bytes of any size
       {Kind::other_magic, "other_magic"},  // a good head but for its first byte
       {Kind::plain, "plain"},              // version 1
       {Kind::cut, "cut"},                  // a member's greeting without its end
       {Kind::hello, "hello"},              // handshakes without the team's key
       {Kind::answer, "answer"},            //
       {Kind::proof, "proof"},              //
       {Kind::cookie, "cookie"},            // that nobody asked for
       {Kind::group, "group"},              // without the team's key
       {Kind::no_session, "no_session"},    // frames of no session that is here
       {Kind::forged, "forged"},            // frames of a living session, which its key did not seal
       {Kind::word, "word"}}};              // OWN of a living session, likewise

  Garbage(const TeamKey& team, std::uint64_t seed) : random_(seed), member_(team, seed) {}

  // A line of a robot's key log: somebody near reads the indices of its sessions off its datagrams.
  void overhear(std::string_view line) {
    constexpr std::string_view kSession = "SESSION ";
    if (!line.starts_with(kSession) || line.size() < kSession.size() + 8) return;
    std::array<std::uint8_t, 4> index{};
    for (std::size_t i = 0; i < index.size(); ++i) {
      const char* const digits = line.data() + kSession.size() + 2 * i;
      std::from_chars(digits, digits + 2, index[i], 16);
    }
    indices_.push_back(index);
  }
  std::size_t sessions() const { return indices_.size(); }

  Datagram make(Kind kind) {
    switch (kind) {
      case Kind::noise:
        return noise(below(kMaxDatagramBytes + 1));
      case Kind::other_magic:
        return with(0, 0x42, of_type(sealed::Type::frames, any_frames()));
      case Kind::plain:
        return with(0, 0xB1, noise(any_frames()));
      case Kind::cut:
        return cut();
      case Kind::hello:
        return of_type(sealed::Type::hello, sealed::kHelloBytes);
      case Kind::answer:
        return of_type(sealed::Type::answer, sealed::kAnswerBytes);
      case Kind::proof:
        return of_type(sealed::Type::proof, sealed::kProofBytes);
      case Kind::cookie:
        return of_type(sealed::Type::cookie, sealed::kCookieBytes);
      case Kind::group:
        return of_type(sealed::Type::group, any_frames());
      case Kind::no_session:
        return of_type(sealed::Type::frames, any_frames());
      case Kind::forged:
        return of_session(of_type(sealed::Type::frames, any_frames()));
      case Kind::word:
        return of_session(of_type(sealed::Type::own, sealed::kOwnBytes));
    }
    return {};
  }

 private:
  std::size_t below(std::size_t end) {
    return static_cast<std::size_t>(random_.integer(0, static_cast<std::int64_t>(end) - 1));
  }
  std::size_t any_frames() {
    return sealed::kGroupOverheadBytes + below(kMaxDatagramBytes + 1 - sealed::kGroupOverheadBytes);
  }
  static Datagram with(std::size_t at, std::uint8_t byte, Datagram bytes) {
    bytes[at] = byte;
    return bytes;
  }
  Datagram noise(std::size_t size) {
    Datagram bytes(size);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random_.next() >> 56);
    return bytes;
  }
  Datagram of_type(sealed::Type type, std::size_t size) {
    Datagram bytes = noise(size);
    sealed::write_head(bytes, type);
    return bytes;
  }
  Datagram cut() {
    Datagram hello = member_.hello(Instant{});
    hello.resize(below(hello.size()));
    return hello;
  }
  // With a count that the session's own could have.
  Datagram of_session(Datagram bytes) {
    if (indices_.empty()) return bytes;
    std::ranges::copy(indices_[below(indices_.size())], bytes.begin() + sealed::kHeadBytes);
    std::fill_n(bytes.begin() + sealed::kHeadBytes + 4, 8, std::uint8_t{0});
    bytes[sealed::kHeadBytes + 6] = static_cast<std::uint8_t>(1 + below(4));
    return bytes;
  }

  test::Random random_;
  OtherSide member_;
  std::vector<std::array<std::uint8_t, 4>> indices_;
};

}  // namespace onemap::comms::sim
