#include "daemon/worker.hpp"

#include <pthread.h>

#include <exception>
#include <new>
#include <utility>

namespace onemap::daemon {

void Failures::add(std::string_view thread, std::string_view what) {
  const std::lock_guard lock(mutex_);
  if (!any_) first_ = std::string(thread) + ": " + std::string(what);
  any_ = true;
}

std::string Failures::first() const {
  const std::lock_guard lock(mutex_);
  return first_;
}

void Worker::start(std::string name, Failures& failures, std::function<void()> body, std::function<void()> at_end) {
  thread_ = std::thread([name = std::move(name), &failures, body = std::move(body), at_end = std::move(at_end)] {
    constexpr std::size_t kLongest = 15;  // the kernel's, for top and gdb
    pthread_setname_np(pthread_self(), name.substr(0, kLongest).c_str());
    try {
      body();
    } catch (...) {
      failures.add(name, what_of_current_exception());
    }
    if (at_end) at_end();
  });
}

void Worker::join() {
  if (thread_.joinable()) thread_.join();
}

std::string what_of_current_exception() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return "out of memory";
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "an exception of an unknown type";
  }
}

Status guarded(std::string_view place, const std::function<Status()>& body) {
  try {
    return body();
  } catch (...) {
    return Error{std::string(place), what_of_current_exception()};
  }
}

}  // namespace onemap::daemon
