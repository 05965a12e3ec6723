#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace onemap::comms {

enum class FrameType : std::uint8_t {
  beacon = 1,
  status = 2,
  have = 3,
  have_request = 4,
  want = 5,
  data = 6,
  ping = 7,
  pong = 8,
  feedback = 10,
  head = 11,
  later_life = 128,  // who does not know this type, or a greater one, skips it
  mass = 129
};
inline constexpr std::array kFrameTypes{FrameType::beacon,       FrameType::status,     FrameType::have,
                                        FrameType::have_request, FrameType::want,       FrameType::data,
                                        FrameType::ping,         FrameType::pong,       FrameType::feedback,
                                        FrameType::head,         FrameType::later_life, FrameType::mass};
// Types up to 14, then those from 128 on; index 0 is not used.
inline constexpr std::size_t kFrameTypeCount = 17;
constexpr std::size_t index_of(FrameType type) {
  const auto number = static_cast<std::size_t>(type);
  return number < 128 ? number : number - 128 + 15;
}

// Why a datagram, a frame or a part of one was refused. The first group throws away the whole datagram, unread.
enum class Refusal : std::uint8_t {
  too_short,        // less than a header
  too_long,         // more than kMaxDatagramBytes
  bad_magic,        // not ours
  bad_version,      // ours, of another major version
  bad_type,         // a datagram type that v1 does not know
  bad_reserved,     // reserved bits are not 0
  bad_frame,        // a frame is malformed, or unknown and not skippable
  bad_robot_id,     // a frame names a robot whose id is no valid name
  bad_incarnation,  // the sender's, or a log's: 2^63 or more is no life
  stranger,         // more than a beacon from an endpoint that is no validated neighbour
  wrong_receiver,   // meant for another incarnation or another robot
  own_echo,         // our own datagram came back (multicast)
  id_conflict,      // somebody else uses our robot id, or two neighbours use one id
  second_path,      // a neighbour that we already have, from another address
  neighbours_full,  // no room for another neighbour
  address_full,     // no room for another neighbour of this address
  candidate,        // another greets from a living neighbour's address; it has to prove that it is there
  former_life,      // a greeting of a life although records of a later one are here; it is told
  duplicate,        // this datagram was already seen
  too_old,          // so late that it cannot be told from a duplicate
  counter_jump,     // so far ahead that the next datagram has to confirm it
  // In a team with a key, before the frames are seen:
  not_sealed,       // a plain datagram
  bad_size,         // not the size that its type has
  bad_mac,          // a handshake by somebody who does not know the team's key; it gets no answer
  under_load,       // a handshake, while there are many: it got a cookie, and shall come again with it
  busy,             // a handshake beyond what one second may cost
  bad_handshake,    // not what the other side would have written, or no handshake that we know of
  bad_cookie,       // an answer to nothing that we asked
  bad_identity,     // a greeting that its own key did not sign
  other_key,        // a robot whose name belongs to another key; people are told
  pins_full,        // there is no room for the key of another robot
  shut_out,         // it spoke nonsense too often, lately
  unknown_session,  // of no session that is here (any longer)
  bad_seal,         // forged, or damaged on the way
  wrong_name,       // it greets in the name of another robot than the one that proved itself
  // Parts of a good datagram:
  logs_full,           // an entry of a version vector beyond max_logs
  robot_logs_full,     // an entry beyond max_logs_of_robot
  robots_full,         // a log of a robot beyond max_robots
  status_unknown,      // a status of a robot, or of a life, of which no record is here
  own_log_ahead,       // somebody claims to hold records of ours that we never wrote
  bad_mass,            // amounts for the team's talks that no honest robot says
  later_life,          // records or a status in our name, of a life that we did not begin
  contradicts_author,  // records of a life later than the one in which their author, a neighbour, greets us
  want_unknown,        // asks for a record that we do not hold
  want_over_credit,    // asks for more than its credit
  data_unasked,        // a fragment of a record that we did not ask for (or no longer need)
  data_conflict,       // fragments of one record disagree about kind, size or hash
  data_bad_hash,       // a record was complete and its hash was wrong; thrown away and asked for again
  bad_signature,       // a complete record is not signed by who is said to have written it
  second_key,          // a log names another key than the one that counts for its robot
  forked,              // its author signed two different records of one place: the log is not taken further
  live_head,           // a head in place of a record that nothing replaces: whoever serves it keeps the body back
  reassembly_full,     // no room in the reassembly budget
  store_refused,       // the store had no room for a complete record
  unreadable,          // a record that the store holds cannot be read back
  append_refused,      // an own record was too large or the store had no room
  count
};
inline constexpr std::size_t kRefusalCount = static_cast<std::size_t>(Refusal::count);
std::string_view name(FrameType type);
std::string_view name(Refusal reason);
std::string_view words(Refusal reason);  // what happened, for people
// An honest team on a lossy net has these every day: to be counted, and no news.
bool everyday(Refusal reason);

// Everything that a node counts; only ever grows.
struct Counters {
  std::uint64_t datagrams_sent = 0, datagrams_received = 0;
  std::uint64_t bytes_sent = 0, bytes_received = 0;  // UDP payload, everything included
  std::array<std::uint64_t, kFrameTypeCount> frames_sent{}, frames_received{};
  std::array<std::uint64_t, kRefusalCount> refused{};
  std::uint64_t body_bytes_sent = 0;       // bytes of record bodies inside DATA frames
  std::uint64_t body_bytes_received = 0;   // of them, bytes that were new
  std::uint64_t duplicate_body_bytes = 0;  // bytes of fragments that were already here
  std::uint64_t records_appended = 0;      // own
  std::uint64_t records_pushed = 0;        // own, sent unasked; each copy counts
  std::uint64_t records_received = 0;      // of others, complete and stored
  std::uint64_t records_pushed_here = 0;   // of others, that came unasked
  std::uint64_t fragments_reasked = 0;     // asked for again after a loss
  std::uint64_t records_retargeted = 0;    // asked for from another neighbour after silence
  std::uint64_t neighbours_lost = 0;       // fell silent for neighbour_timeout

  std::uint64_t of(Refusal reason) const { return refused[static_cast<std::size_t>(reason)]; }
  std::uint64_t sent(FrameType type) const { return frames_sent[index_of(type)]; }
  std::uint64_t received(FrameType type) const { return frames_received[index_of(type)]; }
  void refuse(Refusal reason) { ++refused[static_cast<std::size_t>(reason)]; }
};

}  // namespace onemap::comms
