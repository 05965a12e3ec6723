#pragma once
#include <cstddef>
#include <memory>

#include "hal/base/record.hpp"

namespace onemap::comms {

// Where records are kept. Append in order of sequence; a record is never changed.
class LogStore {
 public:
  virtual ~LogStore() = default;
  virtual bool append(Record record) = 0;  // false: not the next of its log, or no room
  virtual std::shared_ptr<const Record> find(const RecordId& id) const = 0;
  virtual const VersionVector& frontier() const = 0;
  virtual std::size_t bytes() const = 0;
};

}  // namespace onemap::comms
