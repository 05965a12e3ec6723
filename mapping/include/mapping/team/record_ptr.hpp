#pragma once
#include <memory>

#include "hal/base/record.hpp"

namespace onemap::mapping {

using RecordPtr = std::shared_ptr<const Record>;  // the store's own, so that a body is in memory once

}  // namespace onemap::mapping
