#include "hal/base/text_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

namespace onemap {

Result<std::string> read_text_file(const std::string& file) {
  constexpr std::size_t kMaxBytes = 64 << 10;
  std::ifstream in(file, std::ios::binary);
  if (!in) return Error{file, std::string("cannot be read: ") + std::strerror(errno)};
  std::string text(kMaxBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad()) return Error{file, "cannot be read"};  // a folder
  if (!in.eof()) return Error{file, "is larger than 64 KiB"};
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

}  // namespace onemap
