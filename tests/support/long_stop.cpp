// Preloaded into a program: its clocks are ahead by what the file CLOCK_AHEAD says, a 64-bit number of seconds, from
// the moment that somebody writes it there. Written between SIGSTOP and SIGCONT it is what the program can know of a
// stop that was so much longer. What waits in the kernel waits by the kernel's clock.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <ctime>

namespace {

const volatile std::int64_t* ahead_s() {
  static const auto* mapped = [] {
    const char* name = std::getenv("CLOCK_AHEAD");
    const int file = name != nullptr ? open(name, O_RDONLY | O_CLOEXEC) : -1;
    if (file < 0) std::abort();
    const void* at = mmap(nullptr, sizeof(std::int64_t), PROT_READ, MAP_SHARED, file, 0);
    close(file);
    if (at == MAP_FAILED) std::abort();
    return static_cast<const volatile std::int64_t*>(at);
  }();
  return mapped;
}

bool runs_on(clockid_t id) { return id == CLOCK_REALTIME || id == CLOCK_MONOTONIC; }

}  // namespace

extern "C" int clock_gettime(clockid_t id, timespec* t) {
  const long result = syscall(SYS_clock_gettime, id, t);
  if (result == 0 && runs_on(id)) t->tv_sec += *ahead_s();
  return static_cast<int>(result);
}

// std::condition_variable waits until an instant of the program's clock.
extern "C" int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t id,
                                      const timespec* until) {
  using Wait = int (*)(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*);
  static const auto wait = reinterpret_cast<Wait>(dlsym(RTLD_NEXT, "pthread_cond_clockwait"));
  timespec in_kernel = *until;
  if (runs_on(id)) in_kernel.tv_sec -= *ahead_s();
  return wait(condition, mutex, id, &in_kernel);
}
