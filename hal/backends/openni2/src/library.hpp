#pragma once
#include <OpenNI.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/base/result.hpp"

namespace onemap::hal::openni2 {

// What the library says about its last failure, on one line and safe to print.
Error library_error(const std::string& place, const std::string& what);

// The OpenNI2 library with its drivers loaded. It is one for the process: the first of these loads it, the last unloads
// it, and each must outlive what was opened through it.
class Library {
 public:
  static Result<std::shared_ptr<Library>> load();
  ~Library();
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

 private:
  Library() = default;
};

// Hears from the library's threads which devices come and go. It only takes notes: in its callbacks the library must
// not be called.
class Hotplug {
 public:
  static Result<std::unique_ptr<Hotplug>> listen();
  ~Hotplug();
  Hotplug(const Hotplug&) = delete;
  Hotplug& operator=(const Hotplug&) = delete;

  void watch(const std::string& uri);  // forgets what was, and notes when this one leaves
  bool left() const;
  // Waits until a device has come since the last call that answered true.
  bool wait_for_arrival(std::chrono::milliseconds timeout);

 private:
  Hotplug() = default;
  void note_arrival();
  void note_departure(const std::string& uri);
  OniCallbackHandle handle_ = nullptr;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::string uri_;  // these three with mutex_
  bool left_ = false, arrived_ = false;
};

// The devices that the drivers see now.
std::vector<openni::DeviceInfo> connected_devices();

}  // namespace onemap::hal::openni2
