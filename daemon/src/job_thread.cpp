#include "daemon/job_thread.hpp"

#include <utility>

namespace onemap::daemon {

JobThread::JobThread(std::string name) {
  thread_.start(std::move(name), failures_, [this] {
    while (auto job = jobs_.pop()) {
      if (stopping_) break;
      (*job)(stopping_);
    }
  });
}

JobThread::~JobThread() { stop(); }

bool JobThread::post(Job job) { return jobs_.used() < kWaiting && jobs_.push(std::move(job)); }

void JobThread::stop() {
  stopping_ = true;
  jobs_.close();
  thread_.join();
}

}  // namespace onemap::daemon
