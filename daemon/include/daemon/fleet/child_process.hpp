#pragma once
#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

// What a program may take.
struct ChildLimits {
  std::uint64_t address_space_bytes = 0;  // that it may map; 0: as much as this one
  int niceness = 0;                       // added to this one's
};

// A program that this process started. Ends with its parent; destroying a running one kills it.
class ChildProcess {
 public:
  // Both outputs go to the log file, input is empty, no signal is blocked.
  static Result<ChildProcess> start(const std::string& program, const std::vector<std::string>& arguments,
                                    const std::string& log_file, const ChildLimits& limits = {});
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) = delete;
  ~ChildProcess();

  pid_t pid() const { return pid_; }            // -1: ended
  bool running();                               // false once it ended; then exit_text() and exit_code() say how
  void terminate();                             // SIGTERM, if it runs
  void kill();                                  // SIGKILL, if it runs; it has ended when this returns
  bool wait(Duration at_most);                  // true when it ended in time
  int exit_code() const { return exit_code_; }  // 128 + signal when a signal ended it
  std::string exit_text() const;

 private:
  explicit ChildProcess(pid_t pid) : pid_(pid) {}
  pid_t pid_ = -1;  // -1: ended
  int exit_code_ = -1;
};

}  // namespace onemap::daemon
