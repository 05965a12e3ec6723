// This robot's own records: into its log, and on under another life.
#include <algorithm>
#include <utility>

#include "daemon/radio.hpp"
#include "mapping/records/finished.hpp"
#include "mapping/records/hello.hpp"
#include "mapping/records/submap.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kFinishRetry = std::chrono::seconds(1);
constexpr unsigned kMostNewLives = 3;  // neighbours that say more often that we are outlived are wrong
// Needless records that wait for others to name them: a name of its own costs a head.
constexpr std::size_t kMostUnnamed = 64, kMostUnnamedWhenTight = 8;
}  // namespace

void Radio::append_published(Instant now) {
  {
    const std::lock_guard lock(mutex_);
    if (finish_) frames_to_finish_ = std::exchange(finish_, std::nullopt), work_over_ = true;
    node_->set_local_status(now, map_digest_, flags_);
    said_digest_ = map_digest_;
  }
  take_spare();
  replace_keyframes(now);
  name_needless(now, may_wait());
  // What was published before the work was finished is in the queue by now.
  while (auto record = outbox_.try_pop()) append(now, std::move(*record));
  if (!frames_to_finish_ || now < finish_again_) return;
  finish_again_ = now + kFinishRetry;
  if (append_finished(now, *frames_to_finish_)) frames_to_finish_.reset();
}

Result<RecordId> Radio::append_body(Instant now, OutgoingRecord& record) {
  const auto lane = static_cast<std::uint8_t>(record.lane);
  const auto kind = static_cast<std::uint16_t>(record.kind);
  if (record.kind != mapping::RecordKind::submap || needless_.empty())
    return node_->append(now, lane, kind, std::move(record.body));
  auto stored = node_->append(now, lane, kind, record.body, needless_.front().seq);
  if (stored) needless_.pop_front(), ++named_;
  return stored;
}

// Voxel records name those that they make needless, one each. What waits beyond some, or while the store is full, is
// named by records without voxels.
void Radio::name_needless(Instant now, std::size_t leave) {
  const std::vector<std::uint8_t> nothing = encode(mapping::SubmapRecord{0, 20'000, 60'000, {}});
  while (needless_.size() > leave) {
    OutgoingRecord empty{mapping::Lane::voxels, mapping::RecordKind::submap, nothing};
    if (!append_body(now, empty)) return;
    published_.count(empty);
  }
}

// Names may wait while there is room and something will come that carries them.
std::size_t Radio::may_wait() const {
  const bool tight = store_.log->bytes() > config_.store_budget_bytes / 8 * 5;
  return tight || work_over_ ? kMostUnnamedWhenTight : kMostUnnamed;
}

// While the store is full, too: it takes what makes room.
void Radio::replace_keyframes(Instant now) {
  for (; !remains_.empty(); remains_.pop_front(), ++named_) {
    OutgoingRecord place{mapping::Lane::features, mapping::RecordKind::keyframe, remains_.front().body};
    if (!node_->append(now, static_cast<std::uint8_t>(place.lane), static_cast<std::uint16_t>(place.kind), place.body,
                       remains_.front().of.seq))
      return;
    published_.count(place);
  }
}

void Radio::take_spare() {
  mapping::SpareRecords spare;
  {
    const std::lock_guard lock(mutex_);
    spare = std::exchange(spare_, {});
  }
  for (const RecordId& id : spare.needless)
    if (id.log.incarnation == node_config_.incarnation) needless_.push_back(id);
  for (mapping::KeyframeRemains& remains : spare.keyframes)
    if (remains.of.log.incarnation == node_config_.incarnation) remains_.push_back(std::move(remains));
  for (const RecordId& id : spare.unread) let_go_ += node_->let_go(id) ? 1 : 0;
}

void Radio::append(Instant now, OutgoingRecord record) {
  if (record.ends_life_of) return end_life(now, std::move(record));
  const auto stored = append_body(now, record);
  if (stored) return published_.count(record);
  name_needless(now, 0);
  ++published_.refused;
  if (disk_fault() != comms::DiskFault::none) return;  // log_disk() says so
  log_.limited("own record", "a record of this robot is left out of the map: {}; raise network.store_budget_mb",
               stored.error().text());
}

// What Finished promises is what the log holds.
bool Radio::append_finished(Instant now, std::uint32_t frames) {
  const mapping::FinishedRecord finished{std::max(frames, published_.poses), published_.poses, published_.keyframes,
                                         published_.submaps};
  const auto stored = node_->append(now, static_cast<std::uint8_t>(mapping::Lane::control),
                                    static_cast<std::uint16_t>(mapping::RecordKind::finished), encode(finished));
  if (!stored)
    log_.limited(
        "finished",
        "cannot tell the team that this robot has finished: {}; the others wait for run.lost_after_s: make room "
        "on the disk, or raise network.store_budget_mb",
        stored.error().text());
  return stored.ok();
}

// A node for the life that life_ tells by now; what the store holds everybody here has heard of.
void Radio::rise_again() {
  if (store_.kept != nullptr) store_.kept->flush();  // the new node takes all that is here for told
  std::shared_ptr<const Record> known;
  while (node_->next_applied(known)) hand_out(std::move(known));
  sent_before_ += counters().bytes_sent;
  received_before_ += counters().bytes_received;
  node_config_.incarnation = life_.number();
  needless_.clear();
  remains_.clear();
  begin_node();
  logged_refusals_ = {};  // a new node counts anew
  while (node_->next_applied(known)) {
  }
}

// The camera is somewhere else: what comes now hangs on nothing that came before. This life is over and keeps its
// worth.
void Radio::end_life(Instant now, OutgoingRecord hello) {
  take_spare();
  name_needless(now, 0);
  append_finished(now, *hello.ends_life_of);
  hello.ends_life_of.reset();
  const std::uint64_t before = life_.number();
  if (auto kept = life_.begin_after(before); !kept)
    log_.warn("the number of this life cannot be kept: {}; make OUT writable", kept.error().text());
  rise_again();
  published_ = {0, 0, 0, published_.refused};
  listener_.new_life(life_.number(), false);
  append(now, std::move(hello));
  const std::lock_guard lock(mutex_);
  node_->set_local_status(now, map_digest_, flags_);
}

namespace {
// A record in the life after `before`: its Hello says that it repeats that one, so that nothing counts twice.
std::vector<std::uint8_t> again(const Record& record, std::uint64_t before) {
  if (record.kind != static_cast<std::uint16_t>(mapping::RecordKind::hello)) return record.body;
  auto hello = mapping::decode_hello(record.body);
  if (!hello) return record.body;
  hello->repeats = before;
  return encode(*hello);
}
}  // namespace

// Neighbours remember a life of this robot with a greater number than this one (its counter was lost and the clock went
// back): it goes on under a greater one, and writes its own records again.
void Radio::begin_new_life(Instant now) {
  const std::uint64_t outlived = *node_->outlived();
  if (new_lives_ == kMostNewLives) {
    log_.limited("outlived",
                 "a neighbour says that it knows a later life of this robot ({}); not believed a {}th time: look "
                 "whether another robot has this robot.id (onemapctl peers), or whose clock is wrong",
                 outlived, kMostNewLives + 1);
    return;
  }
  ++new_lives_;
  const std::uint64_t before = life_.number();
  if (auto kept = life_.begin_after(outlived); !kept)
    log_.warn("the number of this life cannot be kept: {}; make OUT writable", kept.error().text());
  log_.line("neighbours know a later life of {} ({} after {}): going on as life {}", config_.id, outlived, before,
            life_.number());
  rise_again();
  listener_.new_life(life_.number(), true);
  for (std::uint8_t lane = 0; lane < kLaneCount; ++lane)
    for (std::uint32_t seq = 0; auto record = store_.log->find({{node_config_.self, lane, before}, seq}); ++seq)
      if (record->dropped)
        published_.forget(static_cast<mapping::RecordKind>(record->kind));
      else if (!node_->append(now, lane, record->kind, again(*record, before)))
        log_.limited("own record",
                     "the store has no room for this robot's records in its new life; raise network.store_budget_mb");
  const std::lock_guard lock(mutex_);
  node_->set_local_status(now, map_digest_, flags_);
}

}  // namespace onemap::daemon
