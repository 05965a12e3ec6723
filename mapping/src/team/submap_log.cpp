#include "mapping/team/submap_log.hpp"

#include <algorithm>

#include "mapping/records/submap.hpp"

namespace onemap::mapping {

Status SubmapLog::add(const RecordPtr& record) {
  Entry& entry = all_.emplace_back();
  entry.place.sequence = record->id.seq;
  if (record->dropped) gone_.push_back(static_cast<std::uint32_t>(all_.size() - 1));
  replace(*record);
  if (record->dropped) return success();
  auto header = decode_submap_header(record->body);
  if (!header) return header.error();
  Entry& good = all_.back();
  if (header->blocks > 0)  // one that only names another holds nothing
    good.place.record = heads_alone_ ? head_alone(*record) : record;
  good.place.anchor = header->anchor_keyframe;
  good.place.blocks = static_cast<std::uint32_t>(header->blocks);
  return success();
}

// What it says that it replaces, if that is a record of voxels before it that nothing has replaced.
void SubmapLog::replace(const Record& by) {
  const std::uint32_t sequence = by.seal.replaces;
  if (sequence >= by.id.seq) return;
  const auto at = std::ranges::lower_bound(all_, sequence, {}, [](const Entry& e) { return e.place.sequence; });
  if (at == all_.end() || at->place.sequence != sequence || at->replaced_at != kNever) return;
  at->replaced_at = static_cast<std::uint32_t>(all_.size());
  ++replaced_;
  if (at->place.record != nullptr) waiting_.push_back(static_cast<std::uint32_t>(at - all_.begin()));
}

bool SubmapLog::is_whole(std::size_t extent) const {
  return extent >= least_ &&
         std::ranges::none_of(gone_, [&](std::uint32_t i) { return i < extent && extent < all_[i].replaced_at; });
}

std::size_t SubmapLog::most_whole() const {
  std::size_t extent = all_.size();
  for (bool less = true; less;) {
    less = false;
    for (const std::uint32_t i : gone_)
      if (i < extent && extent < all_[i].replaced_at) extent = i, less = true;
  }
  return extent >= least_ ? extent : 0;
}

std::vector<RecordId> SubmapLog::let_go(std::size_t extent) {
  std::vector<RecordId> out;
  const auto is_over = [&](std::uint32_t i) {
    if (all_[i].replaced_at > extent) return false;
    least_ = std::max<std::size_t>(least_, all_[i].replaced_at);
    return true;
  };
  std::erase_if(gone_, is_over);
  std::erase_if(waiting_, [&](std::uint32_t i) {
    if (!is_over(i)) return false;
    out.push_back(all_[i].place.record->id);
    all_[i].place.record.reset();
    return true;
  });
  return out;
}

}  // namespace onemap::mapping
