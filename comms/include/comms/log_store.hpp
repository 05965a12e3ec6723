#pragma once
#include <cstddef>
#include <functional>
#include <memory>

#include "hal/base/record.hpp"
#include "hal/base/result.hpp"

namespace onemap::comms {

// Where records are kept. Append in order of sequence; a record is never changed.
class LogStore {
 public:
  virtual ~LogStore() = default;
  // The error says why the record is not kept: it is not the next of its log, or there is no room, and then how much
  // room there is and which setting gives more.
  virtual Status append(Record record) = 0;
  // Begins to make durable what was appended and is not; to be called again until durable() says so. The error says why
  // it does not work now.
  virtual Status sync() = 0;
  // So many records of this log outlive a crash, as far as this store can promise anything now: what is beyond must not
  // be told to anybody, or its place in the log would be known while nobody has it.
  virtual std::uint32_t durable(const LogId& log) const = 0;
  virtual std::shared_ptr<const Record> find(const RecordId& id) const = 0;  // nullptr: not here, or unreadable
  // Every record that is held, log by log in the order of LogId, each log in the order of its sequence.
  virtual void scan(const std::function<void(const std::shared_ptr<const Record>&)>& visit) const = 0;
  // Gives up the body of a record that nobody needs any more, and the room that it took. Its head stays
  // (Record::dropped says what the body was), and the frontier as it is: it is not fetched again. False: it is not
  // here, or gone already.
  virtual bool forget(const RecordId& id) = 0;
  virtual const VersionVector& frontier() const = 0;
  virtual std::size_t bytes() const = 0;
};

}  // namespace onemap::comms
