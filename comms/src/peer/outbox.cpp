#include "peer/outbox.hpp"

#include <algorithm>
#include <utility>

namespace onemap::comms {

namespace {
constexpr auto kFullHaveGap = std::chrono::milliseconds(20);
constexpr auto kLaterLifeGap = std::chrono::seconds(1);
constexpr unsigned kLaterLifeRepeats = 3;
constexpr auto kCopiesApart = std::chrono::milliseconds(4);

std::optional<Instant> earlier(std::optional<Instant> a, std::optional<Instant> b) {
  if (!a || !b) return a ? a : b;
  return std::min(*a, *b);
}
}  // namespace

void Outbox::tell_later_life(Instant now, std::uint64_t incarnation) {
  if (later_life_again_ > now) return;
  later_life_due = later_life_ = incarnation;
  later_life_again_ = now + kLaterLifeGap;
  later_life_left_ = kLaterLifeRepeats;
}

void Outbox::tell_later_life_again(Instant now) {
  if (later_life_left_ == 0 || now < later_life_again_) return;
  later_life_due = later_life_;
  later_life_again_ = now + kLaterLifeGap;
  --later_life_left_;
}

void Outbox::tell(const LogId& log, Instant at, bool is_news) {
  changed_.insert(log);
  has_news_ |= is_news;
  have_at_ = earlier(have_at_, at);
}

void Outbox::told(Instant now, std::span<const wire::HaveEntry> entries, std::size_t count, unsigned copies) {
  last_have_ = now;
  if (std::exchange(has_news_, false)) copies_left_ = count < changed_.size() ? 1 : copies;
  if (copies_left_ > 0) --copies_left_;
  if (copies_left_ > 0) {
    have_at_ = now + kCopiesApart;
    return;
  }
  for (std::size_t i = 0; i < count; ++i) changed_.erase(entries[i].log);
  if (changed_.empty()) have_at_.reset();
}

bool Outbox::may_tell_all(Instant now) {
  if (now < next_full_have_) return false;
  next_full_have_ = now + kFullHaveGap;
  return true;
}

void Outbox::want(const wire::WantEntry& entry, Instant at) {
  wants_.push_back(entry);
  want_at_ = earlier(want_at_, at);
}

void Outbox::wanted(Instant now, std::size_t count) {
  wants_.erase(wants_.begin(), wants_.begin() + static_cast<std::ptrdiff_t>(count));
  want_at_ = wants_.empty() ? std::nullopt : std::optional(now);
}

void Outbox::want_nothing() {
  wants_.clear();
  want_at_.reset();
}

bool Outbox::due(Instant now) const {
  return mass_due || later_life_due || have_request_due || have_due(now) || (want_at_ && *want_at_ <= now) ||
         wants_.size() >= kManyWants;
}

std::optional<Instant> Outbox::next() const {
  const auto again = later_life_left_ > 0 ? std::optional(later_life_again_) : std::nullopt;
  return earlier(earlier(have_at_, want_at_), again);
}

void Outbox::fell_silent() {
  changed_.clear();
  have_at_.reset();
  has_news_ = false;
  copies_left_ = 0;
  want_nothing();
  later_life_due.reset();
  later_life_left_ = 0;
}

}  // namespace onemap::comms
