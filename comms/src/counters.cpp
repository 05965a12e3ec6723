#include "comms/counters.hpp"

namespace onemap::comms {

namespace {
struct Texts {
  Refusal reason;
  std::string_view name, words;
  bool everyday = false;
};

// In the order of the enumeration.
constexpr std::array<Texts, kRefusalCount> kTexts{{
    {Refusal::too_short, "too_short", "a datagram shorter than a header"},
    {Refusal::too_long, "too_long", "a datagram longer than the protocol allows"},
    {Refusal::bad_magic, "bad_magic", "a datagram of another protocol"},
    {Refusal::bad_version, "bad_version", "a datagram of another version of the protocol"},
    {Refusal::bad_type, "bad_type", "a datagram of an unknown type"},
    {Refusal::bad_reserved, "bad_reserved", "a datagram with reserved bits set"},
    {Refusal::bad_frame, "bad_frame", "a datagram with a malformed frame"},
    {Refusal::bad_robot_id, "bad_robot_id", "a datagram that names a robot whose id is no valid name"},
    {Refusal::bad_incarnation, "bad_incarnation", "a number of a life that is too great to be one"},
    {Refusal::stranger, "stranger", "more than a greeting from an address that is no proved neighbour", true},
    {Refusal::wrong_receiver, "wrong_receiver", "a datagram meant for another robot or another life", true},
    {Refusal::own_echo, "own_echo", "an own datagram that came back", true},
    {Refusal::id_conflict, "id_conflict", "a greeting with an id that another robot uses already"},
    {Refusal::second_path, "second_path", "a greeting of a known neighbour from a second address", true},
    {Refusal::neighbours_full, "neighbours_full", "a greeting; there is no room for more neighbours"},
    {Refusal::address_full, "address_full", "a greeting; there are too many neighbours of that address already"},
    {Refusal::candidate, "candidate",
     "a greeting under another name or life from a living neighbour's address, until it proves to be there"},
    {Refusal::former_life, "former_life", "a greeting of a robot of whom records of a later life are here; it is told"},
    {Refusal::duplicate, "duplicate", "a datagram that was seen before", true},
    {Refusal::too_old, "too_old", "a datagram that is too late", true},
    {Refusal::counter_jump, "counter_jump", "a datagram whose counter is far ahead, until the next confirms it", true},
    {Refusal::not_sealed, "not_sealed", "a plain datagram, although this team has a key"},
    {Refusal::bad_size, "bad_size", "a datagram that has not the size of its type"},
    {Refusal::bad_mac, "bad_mac", "a handshake by somebody who does not know the team's key"},
    {Refusal::under_load, "under_load", "a handshake, while there are many; it shall come again with a cookie"},
    {Refusal::busy, "busy", "a handshake beyond what one second may cost"},
    {Refusal::bad_handshake, "bad_handshake", "a handshake that is none, or that nobody here began", true},
    {Refusal::bad_cookie, "bad_cookie", "a cookie that nobody here asked for", true},
    {Refusal::bad_identity, "bad_identity", "a handshake with a greeting that its key did not sign"},
    {Refusal::other_key, "other_key", "a robot that has another key than the one that its name belongs to"},
    {Refusal::pins_full, "pins_full", "a robot; there is no room to remember its key"},
    {Refusal::shut_out, "shut_out", "a robot that sent malformed datagrams too often, lately"},
    {Refusal::unknown_session, "unknown_session", "a sealed datagram of no session that is here", true},
    {Refusal::bad_seal, "bad_seal", "a sealed datagram that is forged, damaged, or of another team"},
    {Refusal::wrong_name, "wrong_name", "a greeting in another robot's name than the one that was proved"},
    {Refusal::logs_full, "logs_full", "a log; there is no room for more logs"},
    {Refusal::robot_logs_full, "robot_logs_full", "a log of a robot that has too many already"},
    {Refusal::robots_full, "robots_full", "a log of a robot; there is no room for more robots"},
    {Refusal::status_unknown, "status_unknown", "hearsay about a robot or a life of which no record is here", true},
    {Refusal::own_log_ahead, "own_log_ahead", "an offer of own records that this robot never wrote"},
    {Refusal::bad_mass, "bad_mass", "amounts in the team's talks that no honest robot says: no number, or too great"},
    {Refusal::later_life, "later_life", "records or hearsay in this robot's name, of a life that it did not begin"},
    {Refusal::contradicts_author, "contradicts_author",
     "records of a later life of a robot than the one in which it greets this robot itself"},
    {Refusal::want_unknown, "want_unknown", "a request for a record that is not here"},
    {Refusal::want_over_credit, "want_over_credit", "a request beyond the asker's credit"},
    {Refusal::data_unasked, "data_unasked", "a part of a record that nobody asked for", true},
    {Refusal::data_conflict, "data_conflict", "parts of one record that contradict each other"},
    {Refusal::data_bad_hash, "data_bad_hash", "a record that is not what its hash says"},
    {Refusal::bad_signature, "bad_signature", "a record that is not signed by who is said to have written it"},
    {Refusal::second_key, "second_key", "a record signed by another key than the one that is known of its robot"},
    {Refusal::forked, "forked", "a record of a robot that signed two different ones in one place of its log"},
    {Refusal::live_head, "live_head", "a record without its body, although no later one takes its place"},
    {Refusal::reassembly_full, "reassembly_full", "a part of a record; there is no room to put it together"},
    {Refusal::store_refused, "store_refused", "a record of another robot; the store has no room"},
    {Refusal::unreadable, "unreadable", "a record that is held here and cannot be read back from the disk"},
    {Refusal::append_refused, "append_refused",
     "a record of this robot: too large, or the store has no room or cannot write"},
}};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kTexts.size(); ++i)
    if (kTexts[i].reason != static_cast<Refusal>(i) || kTexts[i].words.empty()) return false;
  return true;
}
static_assert(in_order(), "every refusal has its name and its words");
}  // namespace

std::string_view name(FrameType type) {
  switch (type) {
    case FrameType::beacon:
      return "beacon";
    case FrameType::status:
      return "status";
    case FrameType::have:
      return "have";
    case FrameType::have_request:
      return "have_request";
    case FrameType::want:
      return "want";
    case FrameType::data:
      return "data";
    case FrameType::ping:
      return "ping";
    case FrameType::pong:
      return "pong";
    case FrameType::feedback:
      return "feedback";
    case FrameType::head:
      return "head";
    case FrameType::later_life:
      return "later_life";
    case FrameType::mass:
      return "mass";
  }
  return "unknown";
}

std::string_view name(Refusal reason) {
  return reason < Refusal::count ? kTexts[static_cast<std::size_t>(reason)].name : "none";
}
std::string_view words(Refusal reason) {
  return reason < Refusal::count ? kTexts[static_cast<std::size_t>(reason)].words : "nothing";
}
bool everyday(Refusal reason) { return reason < Refusal::count && kTexts[static_cast<std::size_t>(reason)].everyday; }

}  // namespace onemap::comms
