#pragma once
#include <cstdint>
#include <list>
#include <map>
#include <memory>

#include "hal/base/record.hpp"

namespace onemap::comms {

// The records that were used last, up to a number of bytes; the largest record fits always.
class BodyCache {
 public:
  explicit BodyCache(std::size_t bytes) : budget_(bytes) {}
  std::shared_ptr<const Record> find(const RecordId& id) {
    const auto at = places_.find(id);
    if (at == places_.end()) return nullptr;
    records_.splice(records_.begin(), records_, at->second);
    return records_.front();
  }
  void keep(std::shared_ptr<const Record> record) {
    forget(record->id);
    used_ += cost(*record);
    records_.push_front(std::move(record));
    places_[records_.front()->id] = records_.begin();
    while (used_ > budget_ && records_.size() > 1) forget(records_.back()->id);
  }
  void forget(const RecordId id) {
    const auto at = places_.find(id);
    if (at == places_.end()) return;
    used_ -= cost(**at->second);
    records_.erase(at->second);
    places_.erase(at);
  }
  std::size_t used() const { return used_; }

 private:
  static std::size_t cost(const Record& record) { return record.body.size() + 512; }  // and what it takes to keep it
  std::size_t budget_, used_ = 0;
  std::list<std::shared_ptr<const Record>> records_;  // the last one used is first
  std::map<RecordId, std::list<std::shared_ptr<const Record>>::iterator> places_;
};

}  // namespace onemap::comms
