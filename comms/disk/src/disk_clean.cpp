// Room for what is new: bodies that nobody needs any more, and the segments that they lie in.
#include <algorithm>

#include "comms/record_head.hpp"
#include "disk_store_impl.hpp"

namespace onemap::comms {

using segment::frame_bytes;
using segment::name_of;

bool DiskStore::Impl::forget(const RecordId& id) {
  if (!index.holds(id)) return false;
  RecordPlace place = index.get(id);
  if (place.dropped) return false;
  const auto record = find(id, false);
  if (record == nullptr || record->dropped) return false;
  const std::size_t less = frame_bytes(record->body.size()) - frame_bytes(0);
  if (place.in_memory) {
    const auto same = [&](const Waiting& entry) { return entry.record->id == id; };
    const auto at = std::find_if(waiting.begin(), waiting.end(), same);
    at->record = std::make_shared<const Record>(without_body(*record));
    waiting_bytes -= less;
  } else {
    segments[place.segment].dead += less;
  }
  place.dropped = true;
  index.set(id, place);
  cache.forget(id);
  of_author[id.log.robot] -= std::min<std::uint64_t>(less, of_author[id.log.robot]);
  ++view.dropped_bodies;
  return true;
}

void DiskStore::Impl::bury(const segment::Head& head, const RecordPlace& place) {
  segments[place.segment].dead += frame_bytes(place.dropped ? 0 : head.body_here());
}

void DiskStore::Impl::clean(std::size_t bytes) {
  if (cleaning && cleaning->copied) return;
  if (!cleaning && !choose_victim()) return;
  if (!copy_some(bytes) && cleaning) {
    segments[cleaning->segment].dead = 0;  // it cannot be read, or nothing can be written: not this one
    cleaning.reset();
  }
}

// The one with the greatest part that is dead, a quarter at least.
bool DiskStore::Impl::choose_victim() {
  const auto share = [](const Segment& s) { return static_cast<double>(s.dead) / static_cast<double>(s.bytes); };
  const Segment* best = nullptr;
  for (const auto& [number, one] : segments) {
    if (number == active || one.bytes == 0 || one.dead * 4 < one.bytes) continue;
    if (best != nullptr && share(one) <= share(*best)) continue;
    best = &one;
    cleaning = Cleaning{number, 0, false, false};
  }
  return best != nullptr;
}

bool DiskStore::Impl::copy_some(std::size_t bytes) {
  const std::uint32_t from = cleaning->segment;
  const std::uint64_t end = segments[from].bytes;
  std::vector<std::uint8_t> fixed(segment::kFixedBytes);
  for (std::size_t copied = 0; copied < bytes && cleaning->at < end;) {
    const std::uint64_t at = cleaning->at;
    if (!disk.read(name_of(from), at, fixed)) return false;
    const auto head = segment::read_head(fixed);
    if (!head) {  // a spoilt place
      cleaning->at += segment::kAlign;
      continue;
    }
    cleaning->at += frame_bytes(head->body_here());
    copied += segment::kFixedBytes;
    if (!index.holds(head->id)) continue;
    const RecordPlace place = index.get(head->id);
    if (place.in_memory || place.segment != from || place.at != at) continue;
    const auto record = read(head->id, place);
    RecordPlace to;
    if (record == nullptr || write_frame(*record, to) != DiskFault::none || !cleaning) return false;
    bury(*head, place);
    index.set(head->id, to);
    copied += frame_bytes(record->body.size());
  }
  cleaning->copied = cleaning->at >= end;
  return true;
}

// The copies outlive the machine's power: the originals may go.
void DiskStore::Impl::copied_is_durable() {
  if (!cleaning || !cleaning->covered) return;
  const std::uint32_t number = cleaning->segment;
  cleaning.reset();
  if (disk.remove(name_of(number)) != DiskFault::none) return;
  used -= segments[number].bytes;
  view.reclaimed_bytes += segments[number].bytes;
  segments.erase(number);
}

}  // namespace onemap::comms
