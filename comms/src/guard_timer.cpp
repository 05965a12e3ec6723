// What time brings.
#include <algorithm>

#include "guard_impl.hpp"

namespace onemap::comms {

namespace {
using std::chrono::milliseconds;
using std::chrono::seconds;
constexpr auto kLookGap = milliseconds(500);
constexpr auto kWantedFor = seconds(10);  // a wish of the node; it repeats them every 4 s
constexpr auto kSilence = seconds(10);    // we speak and hear nothing: has it lost our session?
constexpr auto kHigherIdWaits = seconds(10);
}  // namespace

void Guard::Impl::tick() {
  std::erase_if(half_opens, [this](const auto& entry) { return entry.second.over(now); });
  for (auto& [at, link] : links)
    if (link.initiation && !link.initiation->over(now) && link.initiation->next() <= now)
      reply(at, link.initiation->take(now, link.cookie));
  if (now < next_look) return;
  next_look = now + kLookGap;
  for (auto& [at, link] : links) tick(at, link);
  for (auto link = links.begin(); link != links.end();) {
    const Link& l = link->second;
    const bool idle = !l.current && !l.previous && !l.initiation && now - l.wanted >= kWantedFor;
    link = idle && now >= l.not_before ? drop(link) : std::next(link);
  }
}

void Guard::Impl::tick(const Endpoint& at, Link& link) {
  for (auto* session : {&link.current, &link.previous})
    if (*session && (*session)->expired(now)) release(*session);
  if (link.initiation && link.initiation->over(now)) {
    indices.erase(link.initiation->index());
    link.initiation.reset();
  }
  if (link.initiation || now < link.not_before) return;
  const bool wanted = link.wanted != Instant{} && now - link.wanted < kWantedFor;
  if (link.current ? should_renew(link) : wanted) begin(at, link);
}

bool Guard::Impl::should_renew(const Link& link) const {
  const Transport& session = *link.current;
  const bool in_use = link.spoke != Instant{} && now - link.spoke < kWantedFor;
  const bool another_life = link.wanted > link.heard;  // the node speaks to one that has no session yet
  if (!in_use) return another_life && now - link.wanted < kWantedFor;
  const bool mine = config.self < session.peer().robot;
  if (session.worn(now) && (mine || now - session.begun() >= Transport::kRekeyAfter + kHigherIdWaits)) return true;
  return now - link.heard >= kSilence || another_life;
}

Instant Guard::Impl::next_deadline() const {
  if (!replies.empty()) return now;
  Instant next = node.next_deadline();
  if (!links.empty() || !half_opens.empty()) next = std::min(next, std::max(next_look, now));
  for (const auto& [at, link] : links)
    if (link.initiation && !link.initiation->over(now)) next = std::min(next, std::max(link.initiation->next(), now));
  return next;
}

}  // namespace onemap::comms
