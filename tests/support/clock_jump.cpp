// Preloaded into a program: CLOCK_JUMP_AFTER_S seconds after its start the wall clock is CLOCK_JUMP_S seconds off, as
// when somebody sets it, or NTP does.
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <ctime>

namespace {

long from_environment(const char* name) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::strtol(text, nullptr, 10) : 0;
}

timespec read_clock(clockid_t id) {
  timespec t{};
  syscall(SYS_clock_gettime, id, &t);
  return t;
}

const time_t kJumpAt = read_clock(CLOCK_MONOTONIC).tv_sec + from_environment("CLOCK_JUMP_AFTER_S");
const long kJump_s = from_environment("CLOCK_JUMP_S");

}  // namespace

extern "C" int clock_gettime(clockid_t id, timespec* t) {
  const long result = syscall(SYS_clock_gettime, id, t);
  if (result == 0 && id == CLOCK_REALTIME && read_clock(CLOCK_MONOTONIC).tv_sec >= kJumpAt) t->tv_sec += kJump_s;
  return static_cast<int>(result);
}
