#include "sim/disk.hpp"

#include <stdexcept>

#include "comms/memory_store.hpp"
#include "support/passing_disk.hpp"

namespace onemap::comms::sim {

std::unique_ptr<LogStore> NoDisk::open() { return std::make_unique<MemoryStore>(budget_bytes_); }

class LogDisk::Late final : public test::PassingDisk {
 public:
  Late(MemoryDisk& disk, unsigned polls) : PassingDisk(disk), polls_(polls) {}
  void begin_sync(const std::string& name) override {
    left_ = polls_;
    PassingDisk::begin_sync(name);
  }
  std::optional<DiskFault> synced(bool wait) override {
    if (!wait && left_ > 0) return --left_, std::nullopt;
    return PassingDisk::synced(wait);
  }

 private:
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
