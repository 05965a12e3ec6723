#include "room_device.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace onemap::test {

namespace {
OniPixelFormat format_of(const std::string& colour) {
  return colour == "yuv422" ? ONI_PIXEL_FORMAT_YUV422
         : colour == "yuyv" ? ONI_PIXEL_FORMAT_YUYV
         : colour == "grey" ? ONI_PIXEL_FORMAT_GRAY8
         : colour == "jpeg" ? ONI_PIXEL_FORMAT_JPEG
                            : ONI_PIXEL_FORMAT_RGB888;
}
}  // namespace

RoomDevice::RoomDevice(DeviceFile file, std::shared_ptr<RoomFeed> feed, const std::filesystem::path& control)
    : file_(std::move(file)), feed_(std::move(feed)), paused_(control.string() + ".paused") {
  if (file_.steps) steps_ = open((control.string() + ".steps").c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  const OniPixelFormat unit = file_.hundred_um ? ONI_PIXEL_FORMAT_DEPTH_100_UM : ONI_PIXEL_FORMAT_DEPTH_1_MM;
  const int width = feed_->colour().width, height = feed_->colour().height;
  // The one that is wanted is not the first, as in real devices.
  modes_[0] = {{{unit, width / 2, height / 2, 30}, {unit, width, height, 15}, {unit, width, height, 30}}};
  modes_[1] = {{{ONI_PIXEL_FORMAT_RGB888, 2 * width, 2 * height, 15},
                {ONI_PIXEL_FORMAT_YUV422, width, height, 30},
                {ONI_PIXEL_FORMAT_RGB888, width, height, 30}}};
  if (!file_.colour.empty())
    for (OniVideoMode& mode : modes_[1]) mode = {format_of(file_.colour), width, height, 30};
  sensors_[0] = {ONI_SENSOR_DEPTH, 3, modes_[0].data()};
  sensors_[1] = {ONI_SENSOR_COLOR, 3, modes_[1].data()};
  thread_ = std::thread([this] { run(); });
}

RoomDevice::~RoomDevice() {
  closed_ = true;
  thread_.join();
  if (steps_ >= 0) close(steps_);
}

OniVideoMode RoomDevice::mode(OniSensorType sensor) const { return modes_[sensor == ONI_SENSOR_DEPTH ? 0 : 1][0]; }

bool RoomDevice::wait_for_turn(std::uint64_t picture) {
  const auto due = start_ + std::chrono::duration<double>(file_.hz > 0 ? static_cast<double>(picture) / file_.hz : 0);
  while (!closed_) {
    if (gone_ || (file_.on_demand && !(wanted_ && access(paused_.c_str(), F_OK) != 0))) {
      usleep(1000);
    } else if (file_.on_demand) {
      return true;
    } else if (steps_ >= 0) {
      pollfd ready{steps_, POLLIN, 0};
      char step = 0;
      if (poll(&ready, 1, 5) == 1 && read(steps_, &step, 1) == 1) return true;
    } else if (const auto left = due - std::chrono::steady_clock::now(); left <= left.zero()) {
      return true;
    } else {
      std::this_thread::sleep_for(std::min<std::chrono::duration<double>>(left, std::chrono::milliseconds(20)));
    }
  }
  return false;
}

// Nobody looks: nothing is taken, so that the first picture of the room is the first of the stream.
void RoomDevice::run() {
  bool looking = false;
  std::chrono::microseconds first{};
  std::uint64_t pictures = 0;
  while (!closed_) {
    {
      const std::lock_guard lock(mutex_);
      looking = streams_[0] && streams_[1] && streams_[0]->running() && streams_[1]->running();
    }
    if (!looking) {
      usleep(1000);
      start_ = std::chrono::steady_clock::now();
      pictures = 0;
      continue;
    }
    if (!wait_for_turn(pictures++) || !feed_->next()) continue;
    if (pictures == 1 && file_.clock_restarts) first = feed_->time();
    const auto stamp = feed_->time() - first + std::chrono::microseconds(1000);
    const std::lock_guard lock(mutex_);
    if (streams_[1]) streams_[1]->deliver(*feed_, stamp);
    if (streams_[0]) streams_[0]->deliver(*feed_, stamp + std::chrono::microseconds(file_.depth_late_us));
    wanted_ = false;  // both images are there: not before
  }
}

OniStatus RoomDevice::getSensorInfoList(OniSensorInfo** sensors, int* count) {
  *sensors = sensors_.data();
  *count = static_cast<int>(sensors_.size());
  return ONI_STATUS_OK;
}

OniStatus RoomDevice::tryManualTrigger() {
  wanted_ = true;
  return ONI_STATUS_OK;
}

oni::driver::StreamBase* RoomDevice::createStream(OniSensorType sensor) {
  if (sensor != ONI_SENSOR_DEPTH && sensor != ONI_SENSOR_COLOR) return nullptr;
  auto stream = std::make_unique<RoomStream>(*this, sensor);
  const std::lock_guard lock(mutex_);
  streams_[sensor == ONI_SENSOR_DEPTH ? 0 : 1] = stream.get();
  return stream.release();  // the library destroys it by destroyStream
}

void RoomDevice::destroyStream(oni::driver::StreamBase* stream) {
  {
    const std::lock_guard lock(mutex_);
    std::ranges::replace(streams_, static_cast<RoomStream*>(stream), nullptr);
  }
  delete stream;
}

OniBool RoomDevice::isImageRegistrationModeSupported(OniImageRegistrationMode mode) {
  return mode == ONI_IMAGE_REGISTRATION_OFF || file_.registers ? TRUE : FALSE;
}

OniBool RoomDevice::isPropertySupported(int id) {
  return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || id == ONI_DEVICE_PROPERTY_SERIAL_NUMBER ? TRUE : FALSE;
}

OniStatus RoomDevice::getProperty(int id, void* data, int* size) {
  if (id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION && *size >= static_cast<int>(sizeof(OniImageRegistrationMode))) {
    const OniImageRegistrationMode mode =
        registered_ ? ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR : ONI_IMAGE_REGISTRATION_OFF;
    std::memcpy(data, &mode, sizeof mode);
    *size = sizeof mode;
    return ONI_STATUS_OK;
  }
  if (id == ONI_DEVICE_PROPERTY_SERIAL_NUMBER && *size > static_cast<int>(file_.serial.size())) {
    std::memcpy(data, file_.serial.c_str(), file_.serial.size() + 1);
    *size = static_cast<int>(file_.serial.size()) + 1;
    return ONI_STATUS_OK;
  }
  return ONI_STATUS_NOT_SUPPORTED;
}

OniStatus RoomDevice::setProperty(int id, const void* data, int size) {
  if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || size != sizeof(OniImageRegistrationMode))
    return ONI_STATUS_NOT_SUPPORTED;
  OniImageRegistrationMode mode{};
  std::memcpy(&mode, data, sizeof mode);
  if (isImageRegistrationModeSupported(mode) != TRUE) return ONI_STATUS_NOT_SUPPORTED;
  registered_ = mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  return ONI_STATUS_OK;
}

}  // namespace onemap::test
