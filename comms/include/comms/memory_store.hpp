#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <vector>

#include "comms/log_store.hpp"

namespace onemap::comms {

// A LogStore in memory with a byte budget (bodies plus a fixed overhead a record). Full is a normal state: append
// answers false and counts. The last tenth of the budget is kept for lanes 0 and 1 (control and poses), so a flood of
// voxels never keeps a pose out.
class MemoryStore final : public LogStore {
 public:
  static constexpr std::size_t kOverheadBytes = 128;  // charged for each record beside its body
  explicit MemoryStore(std::size_t budget_bytes);

  bool append(Record record) override;
  std::shared_ptr<const Record> find(const RecordId& id) const override;
  const VersionVector& frontier() const override { return frontier_; }
  std::size_t bytes() const override { return used_; }

  std::size_t capacity() const { return budget_; }
  std::size_t used() const { return used_; }
  std::uint64_t refused_full() const { return refused_full_; }    // no room
  std::uint64_t refused_order() const { return refused_order_; }  // not the next of its log

 private:
  std::size_t budget_;
  std::size_t used_ = 0;
  std::uint64_t refused_full_ = 0, refused_order_ = 0;
  std::map<LogId, std::vector<std::shared_ptr<const Record>>> logs_;
  VersionVector frontier_;
};

}  // namespace onemap::comms
