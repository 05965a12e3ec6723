#include "daemon/saved_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>
#include <thread>

namespace onemap::daemon {

namespace fs = std::filesystem;

namespace {
// Of a folder that is a copy: nothing in it is refused or moved for want of room.
comms::DiskStoreConfig no_limit() {
  comms::DiskStoreConfig limits;
  limits.budget_bytes = limits.author_bytes = std::size_t{1} << 40;
  limits.segment_bytes = std::size_t{64} << 20;
  return limits;
}

constexpr int kTries = 1000;
constexpr auto kTryAgain = std::chrono::milliseconds(2);

// How many of a log there are now, when there were `count`; the same: for a while no more came.
std::uint32_t more_of(const LogId& log, std::uint32_t count, const SavedLog::Durable& durable,
                      const std::atomic<bool>& stop) {
  for (int tries = 0; durable && tries < kTries && !stop; ++tries, std::this_thread::sleep_for(kTryAgain))
    if (const std::uint32_t now = durable(log); now > count) return now;
  return count;
}

struct Copied {
  std::uint32_t records = 0, left_out = 0;
};
// Up to the first record that cannot be read, and at least as far as what made bodies needless that are not here.
Result<Copied> copy_log(const comms::LogStore& from, comms::DiskStore& to, const LogId& log, std::uint32_t count,
                        const SavedLog::Durable& durable, const std::atomic<bool>& stop) {
  std::set<std::uint32_t> bare;  // heads alone, without a word of a later record
  for (std::uint32_t seq = 0;; ++seq) {
    if (seq == count && !bare.empty()) count = more_of(log, count, durable, stop);
    if (stop) return Error{"", "the daemon is ending"};
    if (seq == count) return Copied{count, 0};
    const auto record = from.find({log, seq});
    if (record == nullptr) return Copied{seq, count - seq};
    if (auto kept = to.append(*record); !kept) return kept.error();
    if (record->dropped) bare.insert(seq);
    bare.erase(record->seal.replaces);
  }
}

Result<SavedLog::Saved> copy_all(const comms::LogStore& from, const VersionVector& logs, const std::string& folder,
                                 const SavedLog::Durable& durable, const std::atomic<bool>& stop) {
  const auto disk = comms::PosixDisk::open(folder);
  if (!disk) return disk.error();
  const auto store = comms::DiskStore::open(**disk, no_limit());
  if (!store) return store.error();
  SavedLog::Saved saved;
  for (const auto& [log, count] : logs) {
    const auto copied = copy_log(from, **store, log, count, durable, stop);
    if (!copied) return copied.error();
    saved.records += copied->records;
    saved.left_out += copied->left_out;
  }
  (*store)->flush();
  const auto view = (*store)->view();
  if (view.fault != comms::DiskFault::none || view.waiting_records > 0)
    return Error{folder, fmt::format("the disk {}", words(view.fault))};
  saved.bytes = view.bytes;
  return saved;
}

// That the folder has its name shall outlive the machine's power, as its files do.
Status put_in_place(const std::string& partial, const std::string& folder) {
  std::error_code code;
  fs::remove(partial + "/lock", code);
  fs::rename(partial, folder, code);
  if (code) return Error{folder, "cannot be put in place: " + code.message()};
  const int parent = ::open(fs::path(folder).parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (parent >= 0) {
    (void)::fsync(parent);  // some file systems cannot, and say so
    ::close(parent);
  }
  return success();
}
}  // namespace

VersionVector durable_part(const comms::LogStore& store) {
  VersionVector logs;
  for (const auto& [log, count] : store.frontier())
    if (const std::uint32_t safe = std::min(count, store.durable(log)); safe > 0) logs[log] = safe;
  return logs;
}

Result<SavedLog::Saved> SavedLog::save(const comms::LogStore& from, const VersionVector& logs,
                                       const std::string& folder, const std::atomic<bool>& stop,
                                       const Durable& durable) {
  std::error_code none;
  if (fs::symlink_status(folder, none).type() != fs::file_type::not_found) return Error{folder, "it is there already"};
  const std::string partial = folder + ".partial";
  fs::remove_all(partial, none);  // of a life that ended while it saved
  auto saved = copy_all(from, logs, partial, durable, stop);
  if (saved && saved->records == 0) saved = Error{"", "there is no record yet"};
  const Status done = saved ? put_in_place(partial, folder) : Status(saved.error());
  if (!done) fs::remove_all(partial, none);
  return done ? saved : done.error();
}

Result<std::unique_ptr<SavedLog>> SavedLog::open(const std::string& folder, const std::atomic<bool>& stop) {
  auto disk = comms::PosixDisk::open_to_read(folder, stop);
  if (!disk) return disk.error();
  auto saved = std::make_unique<SavedLog>();
  saved->disk_ = std::move(*disk);
  auto store = comms::DiskStore::open(*saved->disk_, no_limit());
  if (!store) return store.error();
  saved->store_ = std::move(*store);
  saved->logs_ = saved->store_->frontier();
  saved->log_ = saved->logs_.begin();
  if (saved->logs_.empty())
    return Error{folder, fmt::format("it holds no record that this version of onemap can read ({} bytes are none, {} "
                                     "records follow such)",
                                     saved->spoilt_bytes(), saved->unreadable())};
  return saved;
}

std::size_t SavedLog::records() const {
  std::size_t sum = 0;
  for (const auto& [log, count] : logs_) sum += count;
  return sum;
}

std::uint64_t SavedLog::unreadable() const { return unreadable_ + store_->view().lost_records; }

std::vector<SavedLog::Entry> SavedLog::next(const VersionVector& held) {
  std::vector<Entry> some;
  for (std::size_t bytes = 0; log_ != logs_.end() && some.size() < kMostRecords && bytes < kMostBytes;) {
    if (!begin_log(held)) continue;
    const auto record = store_->find({log_->first, *seq_});
    if (record == nullptr) {  // it was whole a moment ago
      unreadable_ += log_->second - *seq_;
      log_->second = *seq_;
      continue;
    }
    ++*seq_;
    bytes += record->body.size();
    some.push_back({*record, record->dropped ? instead_of(record->id) : std::nullopt});
  }
  return some;
}

void SavedLog::skip(const LogId& log) {
  if (log_ != logs_.end() && log_->first == log) end_log();
}

// False: nothing more of it is to be read.
bool SavedLog::begin_log(const VersionVector& held) {
  if (!seq_) {
    const auto there = held.find(log_->first);
    seq_ = there == held.end() ? 0 : there->second;
  }
  if (*seq_ < log_->second) return true;
  end_log();
  return false;
}

void SavedLog::end_log() {
  ++log_;
  seq_.reset();
  replaced_by_.clear();
}

// The log is read once for all of them: one by one that would be as often as it has records.
std::optional<comms::SignedHead> SavedLog::instead_of(const RecordId& id) {
  const auto& [log, count] = *log_;
  if (replaced_by_.empty()) {
    replaced_by_.assign(count, kNoSequence);
    for (std::uint32_t seq = 1; seq < count; ++seq)
      if (const auto later = store_->find({log, seq}); later != nullptr && later->seal.replaces < seq)
        replaced_by_[later->seal.replaces] = std::min(replaced_by_[later->seal.replaces], seq);
  }
  const std::uint32_t by = replaced_by_[id.seq];
  const auto later = by == kNoSequence ? nullptr : store_->find({log, by});
  if (later == nullptr) return std::nullopt;
  return comms::SignedHead{comms::head_of(*later), later->seal.signature};
}

}  // namespace onemap::daemon
