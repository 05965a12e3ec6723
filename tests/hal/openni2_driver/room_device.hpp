#pragma once
#include <array>
#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>

#include "openni_driver.hpp"
#include "room_feed.hpp"

namespace onemap::test {

class RoomDevice;

// Depth or colour of a device.
class RoomStream final : public oni::driver::StreamBase {
 public:
  RoomStream(RoomDevice& device, OniSensorType sensor);
  ~RoomStream() override { stop(); }
  OniStatus start() override;
  void stop() override;
  OniStatus getProperty(int id, void* data, int* size) override;
  OniStatus setProperty(int id, const void* data, int size) override;
  OniBool isPropertySupported(int id) override;
  void notifyAllProperties() override;
  bool running();
  // The picture with its stamp to whoever reads the stream.
  void deliver(RoomFeed& feed, std::chrono::microseconds stamp);

 private:
  template <class Pixel>
  void copy_rows(std::span<const Pixel> from, std::size_t channels, void* to) const;
  RoomDevice& device_;
  const OniSensorType sensor_;
  OniVideoMode mode_;
  std::mutex mutex_;
  bool running_ = false;  // with mutex_
  bool mirrored_ = true;  // as PrimeSense's devices start
  int frames_ = 0;
};

// One plugged device: a thread that takes pictures of its room and gives them to the streams that run.
class RoomDevice final : public oni::driver::DeviceBase {
 public:
  // control: the folder and name of its FIFO and its mark of being paused.
  RoomDevice(DeviceFile file, std::shared_ptr<RoomFeed> feed, const std::filesystem::path& control);
  ~RoomDevice() override;
  void pull_out() { gone_ = true; }  // the streams go silent, and nothing else is said

  const DeviceFile& file() const { return file_; }
  const RoomFeed& feed() const { return *feed_; }
  bool registered() const { return registered_; }
  OniVideoMode mode(OniSensorType sensor) const;

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override;
  OniStatus tryManualTrigger() override;  // somebody waits, and no image is left
  oni::driver::StreamBase* createStream(OniSensorType sensor) override;
  void destroyStream(oni::driver::StreamBase* stream) override;
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override;
  OniBool isPropertySupported(int id) override;
  OniStatus getProperty(int id, void* data, int* size) override;
  OniStatus setProperty(int id, const void* data, int size) override;

 private:
  void run();
  bool wait_for_turn(std::uint64_t picture);  // false: the device is closed
  const DeviceFile file_;
  const std::shared_ptr<RoomFeed> feed_;
  const std::string paused_;  // a file
  int steps_ = -1;            // file descriptor of the FIFO
  std::array<std::array<OniVideoMode, 3>, 2> modes_;
  std::array<OniSensorInfo, 2> sensors_;
  std::atomic<bool> registered_ = false, gone_ = false, closed_ = false, wanted_ = false;
  std::mutex mutex_;
  std::array<RoomStream*, 2> streams_{};  // with mutex_: depth, colour
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::thread thread_;
};

}  // namespace onemap::test
