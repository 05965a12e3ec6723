#pragma once
#include <atomic>
#include <memory>

#include "comms/disk/disk.hpp"
#include "hal/base/result.hpp"

namespace onemap::comms {

// A folder of the file system. A thread of its own waits for fdatasync, which on a memory card may take a fifth of a
// second: whoever writes does not.
class PosixDisk final : public Disk {
 public:
  // Makes the folder if it is not there. Another process must not use it: the folder is locked (flock on FOLDER/lock).
  static Result<std::unique_ptr<PosixDisk>> open(const std::string& folder);
  // Of a folder that stays as it is, whoever else uses it: what would change it is refused as read_only. Once given_up
  // is set nothing can be read any more; it must outlive the disk.
  static Result<std::unique_ptr<PosixDisk>> open_to_read(const std::string& folder, const std::atomic<bool>& given_up);
  ~PosixDisk() override;
  PosixDisk(const PosixDisk&) = delete;
  PosixDisk& operator=(const PosixDisk&) = delete;

  std::optional<std::vector<std::string>> list() override;
  std::optional<std::uint64_t> size(const std::string& name) override;
  std::optional<std::size_t> read(const std::string& name, std::uint64_t at, std::span<std::uint8_t> into) override;
  DiskFault write(const std::string& name, std::uint64_t at, std::span<const std::uint8_t> bytes) override;
  DiskFault cut(const std::string& name, std::uint64_t size) override;
  DiskFault remove(const std::string& name) override;
  DiskFault rename(const std::string& name, const std::string& to) override;
  void begin_sync(const std::string& name) override;
  std::optional<DiskFault> synced(bool wait) override;

 private:
  struct Impl;
  explicit PosixDisk(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace onemap::comms
