#pragma once
#include <functional>
#include <memory>

#include "hal/base/record.hpp"

namespace onemap::mapping {

using RecordPtr = std::shared_ptr<const Record>;  // the store's own, so that a body is in memory once

// Where records outlive this process their bodies can be read again when they are wanted. nullptr, or a record without
// its body: it cannot be read, now at least.
using ReadRecord = std::function<RecordPtr(const RecordId&)>;

// What is held of a record whose body can be read again.
inline RecordPtr head_alone(const Record& record) {
  return std::make_shared<const Record>(Record{record.id, record.kind, {}, record.seal, record.dropped});
}
// With its body, of one that has one. nullptr: it cannot be read.
inline RecordPtr whole(const RecordPtr& held, const ReadRecord& read) {
  if (!held->body.empty() || !read) return held;
  RecordPtr again = read(held->id);
  return again != nullptr && !again->body.empty() ? again : nullptr;
}

}  // namespace onemap::mapping
