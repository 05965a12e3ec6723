#pragma once
// The devices that the test driver of OpenNI2 (tests/hal/openni2_driver) gives this process and its children.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "support/temp_folder.hpp"

namespace onemap::test {

class OpenNi2Devices {
 public:
  OpenNi2Devices() { setenv("ONEMAP_TEST_DEVICES", folder_.path().c_str(), 1); }
  ~OpenNi2Devices() {
    unsetenv("ONEMAP_TEST_DEVICES");
    for (const auto& [name, fifo] : steps_) close(fifo);
  }
  OpenNi2Devices(const OpenNi2Devices&) = delete;
  OpenNi2Devices& operator=(const OpenNi2Devices&) = delete;

  // Lines `key value`, see openni2_driver/device_file.hpp.
  void plug(const std::string& name, const std::string& lines) {
    if (!steps_.contains(name)) {
      const std::string fifo = folder_ / (name + ".steps");
      mkfifo(fifo.c_str(), 0600);
      steps_[name] = open(fifo.c_str(), O_RDWR | O_CLOEXEC);  // open for good: else it forgets what was written
    }
    folder_.write(name + ".new", lines);
    std::filesystem::rename(folder_ / (name + ".new"), folder_ / (name + ".device"));
  }
  void unplug(const std::string& name) { std::filesystem::remove(folder_ / (name + ".device")); }
  // Lets a device that was plugged with `steps 1` take one more picture.
  void step(const std::string& name) { EXPECT_EQ(write(steps_.at(name), ".", 1), 1); }
  const TempFolder& folder() const { return folder_; }

 private:
  TempFolder folder_;
  std::map<std::string, int> steps_;  // file descriptors
};

}  // namespace onemap::test
