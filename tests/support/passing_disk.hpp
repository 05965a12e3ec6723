#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "comms/disk/disk.hpp"

namespace onemap::test {

// A disk before another one that does what that does; whoever derives from it does something otherwise.
class PassingDisk : public comms::Disk {
 public:
  explicit PassingDisk(comms::Disk& disk) : disk_(disk) {}
  std::optional<std::vector<std::string>> list() override { return disk_.list(); }
  std::optional<std::uint64_t> size(const std::string& name) override { return disk_.size(name); }
  std::optional<std::size_t> read(const std::string& name, std::uint64_t at, std::span<std::uint8_t> into) override {
    return disk_.read(name, at, into);
  }
  comms::DiskFault write(const std::string& name, std::uint64_t at, std::span<const std::uint8_t> bytes) override {
    return disk_.write(name, at, bytes);
  }
  comms::DiskFault cut(const std::string& name, std::uint64_t size) override { return disk_.cut(name, size); }
  comms::DiskFault remove(const std::string& name) override { return disk_.remove(name); }
  comms::DiskFault rename(const std::string& name, const std::string& to) override { return disk_.rename(name, to); }
  void begin_sync(const std::string& name) override { disk_.begin_sync(name); }
  std::optional<comms::DiskFault> synced(bool wait) override { return disk_.synced(wait); }

 private:
  comms::Disk& disk_;
};

}  // namespace onemap::test
