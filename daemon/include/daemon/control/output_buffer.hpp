#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace onemap::daemon {

// What a socket has not taken yet.
class OutputBuffer {
 public:
  void add(std::string_view bytes);
  // Gives the socket what it takes without waiting. False: the other end is gone.
  bool flush(int socket);
  std::size_t pending() const { return bytes_.size() - at_; }
  std::size_t taken() const { return taken_; }  // bytes, ever

 private:
  std::string bytes_;
  std::size_t at_ = 0, taken_ = 0;
};

}  // namespace onemap::daemon
