#include "mapping/team/submap_log.hpp"

#include <algorithm>
#include <utility>

#include "mapping/records/submap.hpp"

namespace onemap::mapping {

Status SubmapLog::add(const RecordPtr& record) {
  Entry entry;
  entry.place.position = static_cast<std::uint32_t>(size_++);
  entry.place.sequence = record->id.seq;
  replace(record->seal.replaces);
  if (!record->dropped) {
    auto header = decode_submap_header(record->body);
    if (!header) return header.error();
    if (header->blocks == 0) return success();  // it only names another one
    entry.place.record = heads_alone_ ? head_alone(*record) : record;
    entry.place.anchor = header->anchor_keyframe;
    entry.place.blocks = static_cast<std::uint32_t>(header->blocks);
  }
  held_.push_back(std::move(entry));
  return success();
}

// A record of voxels before this one, if nothing has replaced it.
void SubmapLog::replace(std::uint32_t sequence) {
  const auto at = std::ranges::lower_bound(held_, sequence, {}, [](const Entry& e) { return e.place.sequence; });
  if (at == held_.end() || at->place.sequence != sequence || at->replaced_at != kNever) return;
  at->replaced_at = static_cast<std::uint32_t>(size_);
}

const SubmapPlace* SubmapLog::find(std::size_t position) const {
  const auto at = std::ranges::lower_bound(held_, position, {}, [](const Entry& e) { return e.place.position; });
  return at != held_.end() && at->place.position == position ? &at->place : nullptr;
}

bool SubmapLog::is_whole(std::size_t extent) const {
  return extent >= least_ && std::ranges::none_of(held_, [&](const Entry& entry) { return lacks(entry, extent); });
}

std::size_t SubmapLog::most_whole() const {
  std::size_t extent = size_;
  for (auto entry = held_.rbegin(); entry != held_.rend(); ++entry)
    if (lacks(*entry, extent)) extent = entry->place.position;
  return extent >= least_ ? extent : 0;
}

std::vector<RecordId> SubmapLog::let_go(std::size_t extent) {
  std::vector<RecordId> out;
  std::erase_if(held_, [&](const Entry& entry) {
    if (entry.replaced_at > extent) return false;
    least_ = std::max<std::size_t>(least_, entry.replaced_at);
    if (entry.place.record != nullptr) out.push_back(entry.place.record->id);
    return true;
  });
  return out;
}

}  // namespace onemap::mapping
