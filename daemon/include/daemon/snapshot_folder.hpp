#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "hal/base/result.hpp"

namespace onemap::daemon {

// A folder of numbered folders, 000001 and so on, each of which is there whole or not at all; `latest` is a link to the
// newest. Numbers go on where an earlier life left off. The oldest go when there are more than `keep` or when all
// together would be larger than the limit. Used by one thread.
class SnapshotFolder {
 public:
  SnapshotFolder(std::string root, std::size_t keep, std::uint64_t limit_bytes)
      : root_(std::move(root)), keep_(keep), limit_bytes_(limit_bytes) {}

  // An empty folder to write into; what an earlier one left unfinished is gone.
  Result<std::string> begin();
  // Puts what was written in its place, and answers where that is. Refused, and gone, when it alone is larger than the
  // limit.
  Result<std::string> publish();
  void give_up();  // nothing of what was begun stays
  std::uint64_t removed() const { return removed_; }

 private:
  std::vector<std::string> finished() const;  // names, the oldest first
  void make_room(std::uint64_t bytes);
  std::string partial() const { return root_ + "/.partial"; }

  const std::string root_;
  const std::size_t keep_;
  const std::uint64_t limit_bytes_;
  std::uint64_t removed_ = 0;
};

}  // namespace onemap::daemon
