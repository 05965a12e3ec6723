#include "daemon/signals.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

namespace onemap::daemon {

StopSignals::StopSignals(Hangup hangup) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  if (hangup == Hangup::reloads) sigaddset(&set, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  descriptor_ = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
}

// The signals stay blocked: one that comes while the program ends would make it look killed, with all its work done.
StopSignals::~StopSignals() {
  if (descriptor_ >= 0) close(descriptor_);
}

bool StopSignals::wait(Duration at_most) {
  if (stopped_) return true;
  pollfd poll_for{descriptor_, POLLIN, 0};
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(at_most).count();
  if (poll(&poll_for, 1, static_cast<int>(ms)) <= 0) return false;
  const auto signal = take();
  stopped_ = signal && *signal != SIGHUP;
  return stopped_;
}

std::optional<int> StopSignals::take() {
  signalfd_siginfo info{};
  if (read(descriptor_, &info, sizeof info) != sizeof info) return std::nullopt;
  return static_cast<int>(info.ssi_signo);
}

}  // namespace onemap::daemon
