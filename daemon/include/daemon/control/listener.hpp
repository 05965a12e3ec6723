#pragma once
#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>

#include "hal/base/result.hpp"

namespace onemap::daemon {

// A listening stream socket: at a path of this machine, or at a TCP port of its loopback. Everything is non-blocking.
class Listener {
 public:
  // A socket that nobody listens at any more is taken away first; one that somebody does is an error, and so is
  // anything else at the path. Anybody may connect who gets into its folder, which is made (mode 0755) when its parent
  // is there.
  static Result<Listener> at_path(const std::string& path);
  static Result<Listener> at_loopback(const std::string& endpoint);  // ADDR:PORT; port 0: any
  Listener(Listener&& other) noexcept;
  Listener& operator=(Listener&&) = delete;
  ~Listener();  // takes the path away, unless it is somebody else's by now

  enum class Got { connection, nothing, no_descriptors };
  // The next connection's descriptor, without waiting. no_descriptors: one more is there, and this process may open no
  // more; its turn is taken with a descriptor that was kept back, and it is closed.
  Got accept(int& descriptor);

  int descriptor() const { return descriptor_; }
  const std::string& place() const { return place_; }    // the path, or ADDR:PORT with the real port
  std::optional<gid_t> group() const { return group_; }  // of the path

 private:
  Listener(int descriptor, std::string place);
  int descriptor_ = -1, spare_ = -1;
  std::string place_;
  std::optional<gid_t> group_;
  dev_t device_ = 0;
  ino_t inode_ = 0;
};

// An ADDR:PORT of loopback; the error says why it is none.
Status check_loopback(const std::string& endpoint);

// Whether the process at the other end of a connection over the path may change something: it is root's, or of this
// process's user, or one of its groups is the socket's. Over TCP never.
struct Caller {
  bool may_change = false;
  std::string name;  // "pid 12, uid 1000", "127.0.0.1:4711"
};
Caller caller_of(int connection, const Listener& listener);

}  // namespace onemap::daemon
