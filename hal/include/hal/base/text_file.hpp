#pragma once
#include <string>

#include "hal/base/result.hpp"

namespace onemap {

// A small file's whole text (a calibration, a list of settings). The error names the file: it cannot be read, or it is
// larger than 64 KiB and so not what it should be.
Result<std::string> read_text_file(const std::string& file);

}  // namespace onemap
