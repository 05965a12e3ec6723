#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace onemap::comms {

enum class DiskFault : std::uint8_t {
  none,
  no_space,   // ENOSPC, EDQUOT
  read_only,  // EROFS, EACCES, EPERM
  failing,    // EIO, or anything else that the system says
  gone        // the folder is not there any more
};
std::string_view words(DiskFault fault);

// The files of one folder, as few ways as a store needs to use them: what a test must be able to tear, lose, spoil and
// fill. Files are named, written at their end and read anywhere. Used by one thread at a time.
class Disk {
 public:
  virtual ~Disk() = default;
  virtual std::optional<std::vector<std::string>> list() = 0;  // names; nothing: the folder cannot be read
  virtual std::optional<std::uint64_t> size(const std::string& name) = 0;
  // How much was read: less than asked for at the end of the file only. Nothing: it cannot be read.
  virtual std::optional<std::size_t> read(const std::string& name, std::uint64_t at, std::span<std::uint8_t> into) = 0;
  // At the end of the file, which is `at`; a file that is not there is made. After a fault any part may be written.
  virtual DiskFault write(const std::string& name, std::uint64_t at, std::span<const std::uint8_t> bytes) = 0;
  virtual DiskFault cut(const std::string& name, std::uint64_t size) = 0;
  virtual DiskFault remove(const std::string& name) = 0;
  virtual DiskFault rename(const std::string& name, const std::string& to) = 0;
  // What was written to this file so far, and that it is there, shall outlive the machine's power. Takes its time;
  // synced() says when it is done, or, if it may wait, waits for it. One at a time.
  virtual void begin_sync(const std::string& name) = 0;
  virtual std::optional<DiskFault> synced(bool wait) = 0;  // nothing: it still goes on
};

}  // namespace onemap::comms
