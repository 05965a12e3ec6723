#include "sim/disk.hpp"

#include <stdexcept>

#include "comms/memory_store.hpp"

namespace onemap::comms::sim {

std::unique_ptr<LogStore> NoDisk::open() { return std::make_unique<MemoryStore>(budget_bytes_); }

class LogDisk::Late final : public Disk {
 public:
  Late(MemoryDisk& disk, unsigned polls) : disk_(disk), polls_(polls) {}
  std::optional<std::vector<std::string>> list() override { return disk_.list(); }
  std::optional<std::uint64_t> size(const std::string& name) override { return disk_.size(name); }
  std::optional<std::size_t> read(const std::string& name, std::uint64_t at, std::span<std::uint8_t> into) override {
    return disk_.read(name, at, into);
  }
  DiskFault write(const std::string& name, std::uint64_t at, std::span<const std::uint8_t> bytes) override {
    return disk_.write(name, at, bytes);
  }
  DiskFault cut(const std::string& name, std::uint64_t size) override { return disk_.cut(name, size); }
  DiskFault remove(const std::string& name) override { return disk_.remove(name); }
  DiskFault rename(const std::string& name, const std::string& to) override { return disk_.rename(name, to); }
  void begin_sync(const std::string& name) override {
    left_ = polls_;
    disk_.begin_sync(name);
  }
  std::optional<DiskFault> synced(bool wait) override {
    if (!wait && left_ > 0) return --left_, std::nullopt;
    return disk_.synced(wait);
  }

 private:
  MemoryDisk& disk_;
  unsigned polls_, left_ = 0;
};

LogDisk::LogDisk(std::size_t budget_bytes, unsigned polls_of_a_sync)
    : budget_bytes_(budget_bytes), late_(std::make_unique<Late>(disk_, polls_of_a_sync)) {}
LogDisk::~LogDisk() = default;

std::unique_ptr<LogStore> LogDisk::open() {
  disk_.fault = DiskFault::none;
  DiskStoreConfig config;
  config.budget_bytes = budget_bytes_;
  config.index_bytes = 512u << 10;  // each log takes some of its own, and 100 robots have hundreds
  config.cache_bytes = config.waiting_bytes = 256u << 10;
  auto store = DiskStore::open(*late_, config);
  if (!store) throw std::runtime_error(store.error().text());
  store_ = store->get();
  return std::move(*store);
}

bool LogDisk::works() const { return store_->view().fault == DiskFault::none; }

void LogDisk::die() { disk_.fault = DiskFault::failing; }

void LogDisk::crash(Random& random) {
  constexpr std::size_t kNever = ~std::size_t{0} / 2;
  disk_.cut_power_at(kNever, random.next());
  disk_.come_back();
}

void LogDisk::wipe() {
  const std::uint64_t room = disk_.room;
  disk_ = MemoryDisk();
  disk_.room = room;
}

void LogDisk::fill(bool full) {
  disk_.room = ~std::uint64_t{0};
  if (!full) return;
  disk_.room = 0;
  for (const auto& [name, file] : disk_.files()) disk_.room += file.bytes.size();
}

}  // namespace onemap::comms::sim
