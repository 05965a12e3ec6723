// What is found at the start.
#include <fmt/format.h>

#include <algorithm>

#include "disk_store_impl.hpp"

namespace onemap::comms {

using segment::frame_bytes;
using segment::name_of;

namespace {
constexpr std::size_t kReadAtOnce = std::size_t{4} << 20;

// A file, read from its beginning to its end with large reads.
class Window {
 public:
  Window(Disk& disk, std::string name, std::uint64_t size) : disk_(disk), name_(std::move(name)), size_(size) {
    bytes_.resize(std::min<std::uint64_t>(size, kReadAtOnce + segment::kMaxFrameBytes));
  }
  // `count` bytes from there, fewer at the end; none: the disk cannot read them.
  std::span<const std::uint8_t> at(std::uint64_t from, std::size_t count) {
    count = static_cast<std::size_t>(std::min<std::uint64_t>(count, size_ - from));
    if (from < base_ || from + count > base_ + filled_) fill(from);
    const std::size_t skip = static_cast<std::size_t>(from - base_);
    return skip + count <= filled_ ? std::span<const std::uint8_t>(bytes_).subspan(skip, count)
                                   : std::span<const std::uint8_t>();
  }

 private:
  void fill(std::uint64_t from) {
    base_ = from;
    const auto want = static_cast<std::size_t>(std::min<std::uint64_t>(bytes_.size(), size_ - from));
    filled_ = disk_.read(name_, from, std::span(bytes_).first(want)).value_or(0);
  }
  Disk& disk_;
  std::string name_;
  std::uint64_t size_, base_ = 0;
  std::size_t filled_ = 0;
  std::vector<std::uint8_t> bytes_;
};
}  // namespace

Status DiskStore::Impl::load() {
  const auto names = disk.list();
  if (!names) return Error{"the log's folder", "cannot be read"};
  std::vector<std::uint32_t> numbers;
  for (const std::string& name : *names) {
    const auto number = segment::number_of(name);
    if (number && disk.size(name)) numbers.push_back(*number);
    if (!number && name.find(".corrupt-") == std::string::npos)
      view.messages.push_back(fmt::format("{} is no part of the log; it is left alone", name));
  }
  std::sort(numbers.begin(), numbers.end());
  for (const std::uint32_t number : numbers)
    if (!load_segment(number, disk.size(name_of(number)).value_or(0), number == numbers.back()))
      set_aside(name_of(number), "holds no record");
  view.lost_records = index.end_at_absent();
  if (view.lost_records > 0)
    view.messages.push_back(fmt::format(
        "{} records stand behind a place that cannot be read; neighbours are asked for them", view.lost_records));
  index.each_log([this](const LogId& log, std::uint32_t count) { frontier[log] = count; });
  durable_to = frontier;
  // New names behind what was set aside, too: no segment's number is ever used twice.
  active = numbers.empty() ? 1 : numbers.back() + (segments.contains(numbers.back()) ? 0u : 1u);
  if (!segments.contains(active)) return segments[active] = {}, success();
  disk.begin_sync(name_of(active));  // it may have been written by a life that was killed before it could
  works(*disk.synced(true));
  if (view.fault != DiskFault::none) active_spoilt = true;
  return success();
}

// False: there is no record in it.
bool DiskStore::Impl::load_segment(std::uint32_t number, std::uint64_t bytes, bool last) {
  Window file(disk, name_of(number), bytes);
  std::uint64_t at = 0, good_end = 0;
  while (at < bytes) {
    const auto head = segment::read_head(file.at(at, segment::kFixedBytes));
    const std::size_t size = head ? frame_bytes(head->body_here()) : 0;
    if (head && at + size <= bytes && segment::is_whole(file.at(at, size), number)) {
      segments[number].bytes = good_end = at + size;
      found(*head, number, static_cast<std::uint32_t>(at));
      at = good_end;
    } else {
      view.spoilt_bytes += std::min<std::uint64_t>(segment::kAlign, bytes - at);
      at += segment::kAlign;
    }
  }
  if (good_end == 0) return bytes == 0 && disk.remove(name_of(number)) == DiskFault::none;
  if (last && good_end < bytes) {
    view.cut_bytes += bytes - good_end;
    if (disk.cut(name_of(number), good_end) != DiskFault::none) active_spoilt = true;
    bytes = good_end;
  }
  segments[number].bytes = bytes;
  used += bytes;
  return true;
}

// A record may be there twice, when it was moved to make room: the later place counts.
void DiskStore::Impl::found(const segment::Head& head, std::uint32_t number, std::uint32_t at) {
  if (!index.reach(head.id)) return;
  const RecordPlace before = index.get(head.id);
  const std::size_t size = frame_bytes(head.body_here());
  if (!before.absent) {
    segments[before.segment].dead += frame_bytes(before.dropped ? 0 : head.bytes);
  } else {
    of_author[head.id.log.robot] += size;
  }
  index.set(head.id, {number, at, head.dropped, false, false});
}

void DiskStore::Impl::set_aside(const std::string& name, const std::string& why) {
  std::string to;
  for (int k = 1; to.empty() || disk.size(to); ++k) to = fmt::format("{}.corrupt-{}", name, k);
  const bool moved = disk.rename(name, to) == DiskFault::none;
  view.messages.push_back(fmt::format("{} {}; {}", name, why, moved ? "set aside as " + to : "it cannot be set aside"));
}

}  // namespace onemap::comms
