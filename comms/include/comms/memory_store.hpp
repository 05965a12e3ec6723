#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <vector>

#include "comms/log_store.hpp"

namespace onemap::comms {

// A LogStore in memory with a byte budget. It charges what records cost, not what they weigh: bodies, and a fixed
// amount for each record and for each log, measured on glibc (tests/comms/store_test.cpp). Full is a normal state:
// append refuses and says why (who appends counts). The last tenth of the budget is kept for lanes 0 and 1 (control and
// poses), so a flood of voxels never keeps a pose out.
class MemoryStore final : public LogStore {
 public:
  static constexpr std::size_t kRecordBytes = 320;  // charged for each record beside its body
  static constexpr std::size_t kLogBytes = 256;     // and for each log
  explicit MemoryStore(std::size_t budget_bytes);

  Status append(Record record) override;
  Status sync() override { return success(); }
  // Memory outlives nothing, so that all of it is as durable as it will ever be.
  std::uint32_t durable(const LogId& log) const override {
    const auto at = frontier_.find(log);
    return at == frontier_.end() ? 0 : at->second;
  }
  std::shared_ptr<const Record> find(const RecordId& id) const override;
  void scan(const std::function<void(const std::shared_ptr<const Record>&)>& visit) const override;
  bool forget(const RecordId& id) override;
  const VersionVector& frontier() const override { return frontier_; }
  std::size_t bytes() const override { return used_; }

  std::size_t capacity() const { return budget_; }
  std::size_t used() const { return used_; }

 private:
  Error full(const Record& record) const;
  std::size_t budget_;
  std::size_t used_ = 0;
  std::map<LogId, std::vector<std::shared_ptr<const Record>>> logs_;
  VersionVector frontier_;
};

}  // namespace onemap::comms
