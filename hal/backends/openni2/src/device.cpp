#include "device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <thread>
#include <tuple>
#include <vector>

#include "hal/base/text.hpp"
#include "library.hpp"

namespace onemap::hal::openni2 {

namespace {

constexpr double kNominalFocalAt640 = 525;

PixelFormat from_library(openni::PixelFormat format) {
  switch (format) {
    case openni::PIXEL_FORMAT_DEPTH_1_MM:
      return PixelFormat::depth_1_mm;
    case openni::PIXEL_FORMAT_DEPTH_100_UM:
      return PixelFormat::depth_100_um;
    case openni::PIXEL_FORMAT_RGB888:
      return PixelFormat::rgb888;
    case openni::PIXEL_FORMAT_YUV422:
      return PixelFormat::yuv422;
    case openni::PIXEL_FORMAT_YUYV:
      return PixelFormat::yuyv;
    case openni::PIXEL_FORMAT_GRAY8:
      return PixelFormat::grey8;
    default:
      return PixelFormat::other;
  }
}

Mode from_library(const openni::VideoMode& mode) {
  return {from_library(mode.getPixelFormat()), mode.getResolutionX(), mode.getResolutionY(), mode.getFps()};
}

std::vector<Mode> modes_of(openni::Device& device, openni::SensorType sensor) {
  std::vector<Mode> out;
  const openni::SensorInfo* info = device.getSensorInfo(sensor);
  if (!info) return out;
  const auto& modes = info->getSupportedVideoModes();
  for (int i = 0; i < modes.getSize(); ++i) out.push_back(from_library(modes[i]));
  return out;
}

// Half the picture's width is seen under half the field of view. Files may lack the latter: 0.
double focal_px(const openni::VideoStream& stream, int width) {
  const double half = 0.5 * static_cast<double>(stream.getHorizontalFieldOfView());
  return half > 0.05 && half < 1.5 ? 0.5 * width / std::tan(half) : 0;
}

Intrinsics pinhole(const Mode& mode, double focal) {
  Intrinsics k;
  k.width = mode.width;
  k.height = mode.height;
  k.fx = k.fy = focal;
  k.cx = 0.5 * (mode.width - 1);
  k.cy = 0.5 * (mode.height - 1);
  return k;
}

// Turned off where that can be; else the images are turned over when they are decoded.
bool stays_mirrored(openni::VideoStream& stream) {
  stream.setMirroringEnabled(false);
  return stream.getMirroringEnabled();
}

}  // namespace

bool Identity::may_be(const Identity& other) const {
  return name == other.name && vendor == other.vendor && product == other.product &&
         (serial.empty() || other.serial.empty() || serial == other.serial);
}

Identity identity_of(const openni::DeviceInfo& info) {
  return {info.getUri(), std::string(info.getVendor()) + " " + info.getName(), "", info.getUsbVendorId(),
          info.getUsbProductId()};
}

Result<std::unique_ptr<Device>> Device::open(const Address& address, const std::string& uri) {
  std::unique_ptr<Device> self(new Device);
  self->place_ = printable("camera " + uri);
  if (self->device_.open(uri.c_str()) != openni::STATUS_OK)
    return library_error(self->place_, address.file ? "cannot be played" : "cannot be opened");
  self->identity_ = identity_of(self->device_.getDeviceInfo());
  std::array<char, ONI_MAX_STR> serial{};
  int size = static_cast<int>(serial.size()) - 1;
  if (self->device_.getProperty(openni::DEVICE_PROPERTY_SERIAL_NUMBER, serial.data(), &size) == openni::STATUS_OK)
    self->identity_.serial = serial.data();
  if (const Status status = self->start(address); !status) return status.error();
  return self;
}

// The library plays a recording on a thread that walks over the list of streams without a lock. It stands still when no
// image is asked for, or sleeps when no stream runs, and until it does a stream must not be taken out of the list.
Device::~Device() {
  if (device_.isValid() && device_.isFile()) {
    depth_stream_.stop();
    colour_stream_.stop();
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  depth_stream_.destroy();
  colour_stream_.destroy();
  device_.close();
}

Status Device::start(const Address& address) {
  for (const auto& [stream, sensor, what] :
       {std::tuple(&depth_stream_, openni::SENSOR_DEPTH, "depth"), {&colour_stream_, openni::SENSOR_COLOR, "colour"}})
    if (!device_.hasSensor(sensor) || stream->create(device_, sensor) != openni::STATUS_OK)
      return library_error(place_, std::string("gives no ") + what);
  if (const Status status = set_modes(address); !status) return status.error();
  if (const Status status = set_registration(address); !status) return status.error();
  depth_mirrored_ = stays_mirrored(depth_stream_);
  colour_mirrored_ = stays_mirrored(colour_stream_);
  find_intrinsics(address);
  if (device_.isFile()) prepare_recording();
  if (depth_stream_.start() != openni::STATUS_OK) return library_error(place_, "depth does not start");
  if (colour_stream_.start() != openni::STATUS_OK) return library_error(place_, "colour does not start");
  return success();
}

Status Device::set_modes(const Address& address) {
  const auto depth = modes_of(device_, openni::SENSOR_DEPTH), colour = modes_of(device_, openni::SENSOR_COLOR);
  const Result<ModePair> chosen = choose_modes(depth, colour, address.mode);
  if (!chosen) return Error{place_, chosen.error().reason};
  modes_ = *chosen;
  if (device_.isFile()) return success();  // it plays what was recorded
  if (const Status status = set_mode(depth_stream_, modes_.depth); !status) return status.error();
  return set_mode(colour_stream_, modes_.colour);
}

// Drivers say yes and take another mode, so what they took is asked for.
Status Device::set_mode(openni::VideoStream& stream, const Mode& mode) {
  const auto& listed = stream.getSensorInfo().getSupportedVideoModes();
  for (int i = 0; i < listed.getSize(); ++i) {
    if (from_library(listed[i]) != mode) continue;
    if (stream.setVideoMode(listed[i]) != openni::STATUS_OK)
      return library_error(place_, "does not take its mode " + to_string(mode));
    break;
  }
  const Mode taken = from_library(stream.getVideoMode());
  if (taken != mode) return Error{place_, "took " + to_string(taken) + " where " + to_string(mode) + " was set"};
  return success();
}

// A recording answers that it registers and does nothing, so it is never asked to.
Status Device::set_registration(const Address& address) {
  constexpr auto kMode = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  const bool able = !device_.isFile() && device_.isImageRegistrationModeSupported(kMode);
  const imaging::Registration own_choice = able ? imaging::Registration::device : imaging::Registration::ours;
  registration_ = address.lenses.registration.value_or(device_.isFile() ? imaging::Registration::none : own_choice);
  if (registration_ != imaging::Registration::device) {
    if (able) device_.setImageRegistrationMode(openni::IMAGE_REGISTRATION_OFF);
    return success();
  }
  if (!able) return Error{place_, "registration=device: the device cannot register depth to colour"};
  if (device_.setImageRegistrationMode(kMode) != openni::STATUS_OK || device_.getImageRegistrationMode() != kMode)
    return library_error(place_, "does not register depth to colour, though it says that it can");
  return success();
}

void Device::find_intrinsics(const Address& address) {
  const double nominal = kNominalFocalAt640 * modes_.colour.width / 640;
  const double colour = focal_px(colour_stream_, modes_.colour.width);
  colour_is_nominal_ = colour == 0;
  colour_ = pinhole(modes_.colour, colour_is_nominal_ ? nominal : colour);
  colour_.depth_scale = units_per_metre(modes_.depth.format);
  if (address.lenses.calibration.has_lens() && !address.lenses.calibration.apply(colour_))
    assert(false && "the address was checked");
  const double depth = focal_px(depth_stream_, modes_.depth.width);
  depth_ = pinhole(modes_.depth, depth == 0 ? nominal : depth);
  depth_.depth_scale = colour_.depth_scale;
}

// Frame by frame, as they are asked for. It would start again after the last, which is never asked for: a player at
// the end of its file does not stand still (see the destructor).
void Device::prepare_recording() {
  openni::PlaybackControl* control = device_.getPlaybackControl();
  control->setRepeatEnabled(true);
  control->setSpeed(-1);
  recorded_ = {static_cast<std::uint64_t>(std::max(0, control->getNumberOfFrames(depth_stream_))),
               static_cast<std::uint64_t>(std::max(0, control->getNumberOfFrames(colour_stream_)))};
  left_ = recorded_;
}

Device::Image Device::read(openni::VideoFrameRef& into, std::chrono::milliseconds timeout) {
  std::array<openni::VideoStream*, 2> streams{&depth_stream_, &colour_stream_};
  int ready = 0;  // which of them
  const auto limit = static_cast<int>(timeout.count());
  const openni::Status status = openni::OpenNI::waitForAnyStream(streams.data(), 2, &ready, limit);
  if (status == openni::STATUS_TIME_OUT) return Image::none;
  if (status != openni::STATUS_OK || streams[static_cast<std::size_t>(ready)]->readFrame(&into) != openni::STATUS_OK) {
    error_ = library_error(place_, "gives no image");
    return Image::broken;
  }
  int& last = last_index_[static_cast<std::size_t>(ready)];
  if (device_.isFile() && into.getFrameIndex() <= last) {
    error_ = Error{place_, fmt::format("breaks off: {} image {} follows image {}", ready == 0 ? "depth" : "colour",
                                       into.getFrameIndex(), last)};
    return Image::broken;
  }
  last = into.getFrameIndex();
  std::uint64_t& left = left_[static_cast<std::size_t>(ready)];
  left -= std::min<std::uint64_t>(left, 1);
  return ready == 0 ? Image::depth : Image::colour;
}

}  // namespace onemap::hal::openni2
