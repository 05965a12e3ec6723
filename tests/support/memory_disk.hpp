#pragma once
// A Disk in memory that does what real ones do: loses what was not synced, tears writes, flips bits, fills up, fails.
#include <algorithm>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "comms/disk/disk.hpp"
#include "support/random.hpp"

namespace onemap::comms::sim {

struct PowerCut : std::runtime_error {
  PowerCut() : std::runtime_error("the power is gone") {}
};

class MemoryDisk final : public Disk {
 public:
  static constexpr std::size_t kSector = 512;
  // Every change of the disk is a point at which the power may go: before the n-th from now (0 is the next), or in the
  // middle of it.
  void cut_power_at(std::size_t n, std::uint64_t seed) { cut_at_ = operations_ + n, random_ = test::Random(seed); }
  std::size_t operations() const { return operations_; }
  // What is there when the power is back: of what was not synced any sectors, in any state; a new file perhaps not.
  void come_back() {
    fault = DiskFault::none;
    cut_at_.reset();
    syncing_.reset();
    dark_ = false;
    for (auto it = files_.begin(); it != files_.end();) {
      File& file = it->second;
      if (!file.named && random_.below(3) == 0) {
        it = files_.erase(it);
        continue;
      }
      lose_some(file);
      ++it;
    }
  }

  DiskFault fault = DiskFault::none;       // of every write and sync from now on
  DiskFault sync_fault = DiskFault::none;  // of the next sync alone
  std::uint64_t room = ~std::uint64_t{0};  // bytes of all files
  bool slow = false;                       // syncs go on until somebody waits, or finish() is called
  std::size_t syncs = 0;
  void finish() { slow = false; }

  struct File {
    std::vector<std::uint8_t> bytes, synced;
    bool named = false;  // its being there is synced
  };
  std::map<std::string, File>& files() { return files_; }
  void put(const std::string& name, const std::string& text) {
    files_[name] = {{text.begin(), text.end()}, {text.begin(), text.end()}, true};
  }

  std::optional<std::vector<std::string>> list() override {
    if (fault == DiskFault::gone) return std::nullopt;
    std::vector<std::string> names;
    for (const auto& [name, file] : files_) names.push_back(name);
    return names;
  }
  std::optional<std::uint64_t> size(const std::string& name) override {
    const auto at = files_.find(name);
    return at == files_.end() ? std::nullopt : std::optional<std::uint64_t>(at->second.bytes.size());
  }
  std::optional<std::size_t> read(const std::string& name, std::uint64_t at, std::span<std::uint8_t> into) override {
    const auto file = files_.find(name);
    if (file == files_.end()) return std::nullopt;
    const auto& bytes = file->second.bytes;
    const std::size_t n = at >= bytes.size() ? 0 : std::min<std::size_t>(into.size(), bytes.size() - at);
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), n, into.begin());
    return n;
  }
  DiskFault write(const std::string& name, std::uint64_t at, std::span<const std::uint8_t> bytes) override {
    const bool cut = operate();
    if (fault != DiskFault::none) return fault;
    File& file = files_[name];
    std::size_t n = bytes.size();
    if (cut) n = random_.below(bytes.size() + 1);
    const bool full = total() + n > room;
    if (full) n = room > total() ? static_cast<std::size_t>(room - total()) : 0;
    file.bytes.resize(static_cast<std::size_t>(at));
    file.bytes.insert(file.bytes.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n));
    if (cut) throw PowerCut();
    return full ? DiskFault::no_space : DiskFault::none;
  }
  DiskFault cut(const std::string& name, std::uint64_t size) override {
    if (operate()) throw PowerCut();
    if (fault != DiskFault::none) return fault;
    const auto at = files_.find(name);
    if (at == files_.end()) return DiskFault::gone;
    at->second.bytes.resize(static_cast<std::size_t>(size));
    return DiskFault::none;
  }
  DiskFault remove(const std::string& name) override {
    const bool cut = operate();
    if (fault != DiskFault::none) return fault;
    if (!cut || random_.below(2) == 0) files_.erase(name);
    if (cut) throw PowerCut();
    return DiskFault::none;
  }
  DiskFault rename(const std::string& name, const std::string& to) override {
    if (operate()) throw PowerCut();
    if (fault != DiskFault::none) return fault;
    files_[to] = std::move(files_[name]);
    files_.erase(name);
    return DiskFault::none;
  }
  void begin_sync(const std::string& name) override {
    ++syncs;
    syncing_ = name;
    if (operate()) {
      if (random_.below(2) == 0) keep(name);
      throw PowerCut();
    }
  }
  std::optional<DiskFault> synced(bool wait) override {
    if (!syncing_) return last_;
    if (slow && !wait) return std::nullopt;
    last_ = fault != DiskFault::none ? fault : std::exchange(sync_fault, DiskFault::none);
    if (last_ == DiskFault::none) keep(*syncing_);
    syncing_.reset();
    return last_;
  }

 private:
  // Whether the power goes now. When it is gone nothing is done any more, whoever still tries.
  bool operate() {
    if (dark_) fault = DiskFault::failing;
    if (dark_ || operations_++ != cut_at_) return false;
    return dark_ = true;
  }
  std::uint64_t total() const {
    std::uint64_t sum = 0;
    for (const auto& [name, file] : files_) sum += file.bytes.size();
    return sum;
  }
  void keep(const std::string& name) {
    const auto at = files_.find(name);
    if (at == files_.end()) return;
    at->second.synced = at->second.bytes;
    at->second.named = true;
  }
  void lose_some(File& file) {
    const std::vector<std::uint8_t> now = std::exchange(file.bytes, file.synced);
    if (now.size() < file.bytes.size() && random_.below(2) == 0) file.bytes.resize(now.size());  // it was cut
    if (now.size() > file.bytes.size())
      file.bytes.resize(file.bytes.size() + random_.below(now.size() - file.bytes.size() + 1));
    for (std::size_t at = file.synced.size() / kSector * kSector; at < file.bytes.size(); at += kSector) {
      const std::uint64_t fate = random_.below(4);
      for (std::size_t k = std::max(at, file.synced.size()); k < std::min(at + kSector, file.bytes.size()); ++k)
        if (fate < 2 || (fate == 2 && k % 2 == 0)) file.bytes[k] = now[k];
    }
    file.synced = file.bytes;
    file.named = true;
  }
  std::map<std::string, File> files_;
  std::size_t operations_ = 0;
  bool dark_ = false;
  std::optional<std::size_t> cut_at_;
  std::optional<std::string> syncing_;
  DiskFault last_ = DiskFault::none;
  test::Random random_{1};
};

}  // namespace onemap::comms::sim
