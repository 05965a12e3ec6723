#include "sim/disk.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "comms/memory_store.hpp"
#include "comms/wire/frames.hpp"
#include "hal/base/bytes.hpp"

namespace onemap::comms::sim {

namespace {
constexpr std::size_t kHeadBytes = 16 + 1 + 8 + 4 + 2 + 4 + 8;

std::uint64_t checksum(std::span<const std::uint8_t> head, std::span<const std::uint8_t> body) {
  return wire::body_hash(0, head) ^ wire::body_hash(1, body);
}

// Behind the head: the seal, what is left of a body that was dropped, the body.
std::vector<std::uint8_t> rest_of(const Record& record) {
  std::vector<std::uint8_t> rest;
  ByteWriter out(rest);
  out.bytes(record.seal.previous);
  out.put(record.seal.replaces);
  out.bytes(record.seal.signature);
  out.put(static_cast<std::uint8_t>(record.dropped ? 1 : 0));
  if (record.dropped) {
    out.put(record.dropped->bytes);
    out.bytes(record.dropped->digest);
  }
  out.bytes(record.body);
  return rest;
}

void read_rest(ByteReader in, Record& record) {
  get_bytes(in, record.seal.previous);
  record.seal.replaces = in.get<std::uint32_t>();
  get_bytes(in, record.seal.signature);
  if (in.get<std::uint8_t>() == 1) {
    record.dropped.emplace();
    record.dropped->bytes = in.get<std::uint32_t>();
    get_bytes(in, record.dropped->digest);
  }
  const auto body = in.bytes(in.remaining());
  record.body.assign(body.begin(), body.end());
}

void write_record(const Record& record, std::vector<std::uint8_t>& file) {
  const std::vector<std::uint8_t> rest = rest_of(record);
  std::array<std::uint8_t, kHeadBytes> head;
  std::uint8_t* at = std::copy(record.id.log.robot.bytes.begin(), record.id.log.robot.bytes.end(), head.begin());
  at = put_little_endian(at, record.id.log.lane);
  at = put_little_endian(at, record.id.log.incarnation);
  at = put_little_endian(at, record.id.seq);
  at = put_little_endian(at, record.kind);
  at = put_little_endian(at, static_cast<std::uint32_t>(rest.size()));
  put_little_endian(at, checksum(std::span(head).first(kHeadBytes - 8), rest));
  file.insert(file.end(), head.begin(), head.end());
  file.insert(file.end(), rest.begin(), rest.end());
}

std::optional<Record> read_record(ByteReader& in) {
  const auto head = in.bytes(kHeadBytes - 8);
  ByteReader fields(head);
  Record record;
  get_bytes(fields, record.id.log.robot.bytes);
  record.id.log.lane = fields.get<std::uint8_t>();
  record.id.log.incarnation = fields.get<std::uint64_t>();
  record.id.seq = fields.get<std::uint32_t>();
  record.kind = fields.get<std::uint16_t>();
  const auto size = fields.get<std::uint32_t>();
  const auto sum = in.get<std::uint64_t>();
  const auto rest = in.bytes(size);
  if (!in.ok() || sum != checksum(head, rest)) return std::nullopt;
  read_rest(ByteReader(rest), record);
  return record;
}
}  // namespace

std::unique_ptr<LogStore> NoDisk::open() { return std::make_unique<MemoryStore>(budget_bytes_); }

class JournalStore final : public LogStore {
 public:
  explicit JournalStore(JournalDisk& disk) : disk_(disk), records_(disk.budget_bytes_) {
    ByteReader in(disk.file_);
    std::size_t good = 0;
    while (in.remaining() > 0) {
      auto record = read_record(in);
      if (!record || !records_.append(std::move(*record))) break;
      good = disk.file_.size() - in.remaining();
    }
    disk_.file_.resize(good);
    disk_.durable_ = good;
    durable_to_ = records_.frontier();
  }
  Status append(Record record) override {
    std::vector<std::uint8_t> bytes;
    write_record(record, bytes);
    if (auto kept = records_.append(std::move(record)); !kept) return kept;
    disk_.file_.insert(disk_.file_.end(), bytes.begin(), bytes.end());
    return success();
  }
  Status sync() override {
    disk_.durable_ = disk_.file_.size();
    durable_to_ = records_.frontier();
    return success();
  }
  std::uint32_t durable(const LogId& log) const override {
    const auto at = durable_to_.find(log);
    return at == durable_to_.end() ? 0 : at->second;
  }
  std::shared_ptr<const Record> find(const RecordId& id) const override { return records_.find(id); }
  void scan(const std::function<void(const std::shared_ptr<const Record>&)>& visit) const override {
    records_.scan(visit);
  }
  bool forget(const RecordId& id) override { return records_.forget(id); }
  const VersionVector& frontier() const override { return records_.frontier(); }
  std::size_t bytes() const override { return records_.bytes(); }

 private:
  JournalDisk& disk_;
  MemoryStore records_;
  VersionVector durable_to_;
};

std::unique_ptr<LogStore> JournalDisk::open() { return std::make_unique<JournalStore>(*this); }

void JournalDisk::crash(Random& random) {
  const std::size_t unsynced = file_.size() - durable_;
  const std::size_t left = unsynced == 0 ? 0 : random.below(unsynced + 1);
  file_.resize(durable_ + left);
  if (left > 0 && random.below(2) == 0) file_[durable_ + random.below(left)] ^= 0x40;
}

void JournalDisk::wipe() {
  file_.clear();
  durable_ = 0;
}

}  // namespace onemap::comms::sim
