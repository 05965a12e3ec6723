#include "peer/peer_frontier.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "comms/frontier.hpp"

namespace onemap::comms {

using std::chrono::milliseconds;

namespace {
constexpr std::uint64_t kReordered = 64;  // datagrams that may overtake each other
constexpr auto kRefusedRetry = std::chrono::seconds(4);
constexpr auto kRequestGap = milliseconds(50);
constexpr unsigned kRequestsInVain = 4;
constexpr unsigned kPatientRequests = 6, kMostSteps = 5;  // then twice as long each time
}  // namespace

std::uint32_t PeerFrontier::count(const LogId& log) const {
  const std::uint32_t* const known = logs_.find(log);
  return known == nullptr ? 0 : *known;
}

bool PeerFrontier::raise(const LogId& log, std::uint32_t count) {
  std::uint32_t& known = logs_[log];
  if (count <= known) return false;
  digest_ += entry_digest(log, count) - entry_digest(log, known);
  known = count;
  return true;
}

void PeerFrontier::doubt(const RobotId& robot, std::uint64_t after) {
  for (auto& [log, count] : logs_)
    if (log.robot == robot && log.incarnation > after) digest_ -= entry_digest(log, std::exchange(count, 0));
}

void PeerFrontier::refused_some() {
  refused_some_ = true;
  if (request_at_) request_at_ = not_too_often(*request_at_);
}

// A difference may go away by itself in a moment. That the peer speaks makes another try worth while, however many went
// unanswered.
void PeerFrontier::claim(Instant now, std::uint64_t datagram, std::uint64_t digest, Duration round_trip) {
  if (datagram < claimed_in_ && claimed_in_ - datagram <= kReordered) return;
  claimed_in_ = datagram;
  claimed_ = digest;
  if (digest == digest_) {
    request_at_.reset();
    requests_ = 0;
    refused_some_ = false;
    return;
  }
  const Instant at = not_too_often(now + kRequestGap + round_trip);
  request_at_ = request_at_ ? std::min(*request_at_, at) : at;
}

bool PeerFrontier::requested(Instant now, Duration round_trip) {
  const unsigned steps = std::clamp(requests_, kPatientRequests, kPatientRequests + kMostSteps) - kPatientRequests;
  last_request_ = now;
  ++requests_;
  refused_some_ = false;  // the answer shows whether there still is such an entry
  request_at_ = not_too_often(now + (kRequestGap + 2 * round_trip) * (1u << steps));
  // More seldom each time: what takes many datagrams has time to come through losses.
  if (requests_ < kRequestsInVain || !std::has_single_bit(requests_)) return false;
  logs_.clear();
  digest_ = 0;
  return true;
}

void PeerFrontier::judge_again(Instant now) {
  if (!std::exchange(refused_some_, false)) return;
  requests_ = 0;
  request_at_ = std::max(now, last_request_ + kRequestGap);
}

// What was refused of its frontier will differ again.
Instant PeerFrontier::not_too_often(Instant request) const {
  return refused_some_ ? std::max(request, last_request_ + kRefusedRetry) : request;
}

}  // namespace onemap::comms
