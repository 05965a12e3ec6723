#include "comms/counters.hpp"

namespace onemap::comms {

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
  }
  return "unknown";
}

std::string_view name(Refusal reason) {
  switch (reason) {
    case Refusal::too_short:
      return "too_short";
    case Refusal::too_long:
      return "too_long";
    case Refusal::bad_magic:
      return "bad_magic";
    case Refusal::bad_version:
      return "bad_version";
    case Refusal::bad_type:
      return "bad_type";
    case Refusal::bad_reserved:
      return "bad_reserved";
    case Refusal::bad_frame:
      return "bad_frame";
    case Refusal::stranger:
      return "stranger";
    case Refusal::wrong_receiver:
      return "wrong_receiver";
    case Refusal::own_echo:
      return "own_echo";
    case Refusal::id_conflict:
      return "id_conflict";
    case Refusal::second_path:
      return "second_path";
    case Refusal::neighbours_full:
      return "neighbours_full";
    case Refusal::duplicate:
      return "duplicate";
    case Refusal::too_old:
      return "too_old";
    case Refusal::logs_full:
      return "logs_full";
    case Refusal::robots_full:
      return "robots_full";
    case Refusal::own_log_ahead:
      return "own_log_ahead";
    case Refusal::want_unknown:
      return "want_unknown";
    case Refusal::want_over_credit:
      return "want_over_credit";
    case Refusal::data_unasked:
      return "data_unasked";
    case Refusal::data_conflict:
      return "data_conflict";
    case Refusal::data_bad_hash:
      return "data_bad_hash";
    case Refusal::reassembly_full:
      return "reassembly_full";
    case Refusal::store_refused:
      return "store_refused";
    case Refusal::append_refused:
      return "append_refused";
    case Refusal::count:
      break;
  }
  return "none";
}

std::string_view words(Refusal reason) { return name(reason); }

}  // namespace onemap::comms
