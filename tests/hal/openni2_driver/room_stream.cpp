#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "room_device.hpp"

namespace onemap::test {

namespace {
template <class T>
OniStatus give(const T& value, void* data, int* size) {
  if (*size < static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof value);
  *size = sizeof value;
  return ONI_STATUS_OK;
}
// A recording of a stream that lacks one of the first three plays nothing.
constexpr std::array kProperties{
    ONI_STREAM_PROPERTY_VIDEO_MODE, ONI_STREAM_PROPERTY_STRIDE,       ONI_STREAM_PROPERTY_CROPPING,
    ONI_STREAM_PROPERTY_MIRRORING,  ONI_STREAM_PROPERTY_VERTICAL_FOV, ONI_STREAM_PROPERTY_HORIZONTAL_FOV,
    ONI_STREAM_PROPERTY_MAX_VALUE,
};

int bytes_of(OniPixelFormat format) {
  return format == ONI_PIXEL_FORMAT_RGB888 ? 3 : format == ONI_PIXEL_FORMAT_GRAY8 ? 1 : 2;
}

std::uint8_t in_range(double value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5, 16.0, 240.0)); }

// Grey is green's; two pixels of the others share the colour of their mean, by BT.601 in its video range.
void put_pixels(OniPixelFormat format, std::span<const std::uint8_t> rgb, void* to) {
  auto* out = static_cast<std::uint8_t*>(to);
  const std::size_t first = format == ONI_PIXEL_FORMAT_YUYV ? 0 : 1;
  for (std::size_t i = 0; i + 5 < rgb.size(); i += 6) {
    const std::uint8_t* p = &rgb[i];
    if (format == ONI_PIXEL_FORMAT_GRAY8) {
      out[i / 3] = p[1], out[i / 3 + 1] = p[4];
      continue;
    }
    const double r = (p[0] + p[3]) / 2.0, g = (p[1] + p[4]) / 2.0, b = (p[2] + p[5]) / 2.0;
    std::uint8_t* four = out + i / 6 * 4;
    four[first] = in_range(16 + 0.257 * p[0] + 0.504 * p[1] + 0.098 * p[2]);
    four[first + 2] = in_range(16 + 0.257 * p[3] + 0.504 * p[4] + 0.098 * p[5]);
    four[1 - first] = in_range(128 - 0.148 * r - 0.291 * g + 0.439 * b);
    four[3 - first] = in_range(128 + 0.439 * r - 0.368 * g - 0.071 * b);
  }
}
}  // namespace

RoomStream::RoomStream(RoomDevice& device, OniSensorType sensor)
    : device_(device), sensor_(sensor), mode_(device.mode(sensor)) {}

OniStatus RoomStream::start() {
  const std::lock_guard lock(mutex_);
  running_ = true;
  return ONI_STATUS_OK;
}

void RoomStream::stop() {
  const std::lock_guard lock(mutex_);
  running_ = false;
}

bool RoomStream::running() {
  const std::lock_guard lock(mutex_);
  return running_;
}

OniStatus RoomStream::getProperty(int id, void* data, int* size) {
  const bool depth = sensor_ == ONI_SENSOR_DEPTH;
  const double focal = depth ? device_.feed().depth_focal_px() : device_.feed().colour().fx;
  switch (id) {
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return give(mode_, data, size);
    case ONI_STREAM_PROPERTY_STRIDE:
      return give(mode_.resolutionX * (depth ? 2 : bytes_of(mode_.pixelFormat)), data, size);
    case ONI_STREAM_PROPERTY_CROPPING:
      return give(OniCropping{FALSE, 0, 0, mode_.resolutionX, mode_.resolutionY}, data, size);
    case ONI_STREAM_PROPERTY_MIRRORING:
      return give(OniBool{mirrored_ ? TRUE : FALSE}, data, size);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      return give(static_cast<float>(2 * std::atan(mode_.resolutionX / (2 * focal))), data, size);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
      return give(static_cast<float>(2 * std::atan(mode_.resolutionY / (2 * focal))), data, size);
    case ONI_STREAM_PROPERTY_MAX_VALUE:
      return give(depth ? 65535 : 255, data, size);
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

OniStatus RoomStream::setProperty(int id, const void* data, int size) {
  if (id == ONI_STREAM_PROPERTY_VIDEO_MODE && size == sizeof(OniVideoMode)) {
    std::memcpy(&mode_, data, sizeof mode_);
    if (device_.file().substitutes) mode_.resolutionX /= 2, mode_.resolutionY /= 2;
    return ONI_STATUS_OK;
  }
  if (id == ONI_STREAM_PROPERTY_MIRRORING && size == sizeof(OniBool)) {
    OniBool value{};
    std::memcpy(&value, data, sizeof value);
    mirrored_ = value != FALSE;
    return ONI_STATUS_OK;
  }
  return ONI_STATUS_NOT_SUPPORTED;
}

OniBool RoomStream::isPropertySupported(int id) {
  return std::ranges::find(kProperties, id) != kProperties.end() ? TRUE : FALSE;
}

void RoomStream::notifyAllProperties() {
  std::array<char, sizeof(OniVideoMode) + sizeof(OniCropping)> value{};
  for (const int id : kProperties) {
    int size = value.size();
    if (getProperty(id, value.data(), &size) == ONI_STATUS_OK) raisePropertyChanged(id, value.data(), size);
  }
}

template <class Pixel>
void RoomStream::copy_rows(std::span<const Pixel> from, std::size_t channels, void* to) const {
  const auto width = static_cast<std::size_t>(mode_.resolutionX);
  auto* out = static_cast<Pixel*>(to);
  for (std::size_t i = 0; i < from.size(); i += channels) {
    const std::size_t x = i / channels % width, row = i - x * channels;
    const std::size_t at = row + (mirrored_ ? width - 1 - x : x) * channels;
    for (std::size_t c = 0; c < channels; ++c) out[at + c] = from[i + c];
  }
}

void RoomStream::deliver(RoomFeed& feed, std::chrono::microseconds stamp) {
  const std::lock_guard lock(mutex_);
  // A mode other than the room's own is there to be taken by mistake: nothing comes in it.
  if (!running_ || mode_.resolutionX != feed.colour().width) return;
  OniFrame* frame = getServices().acquireFrame();
  if (!frame) return;
  const bool depth = sensor_ == ONI_SENSOR_DEPTH;
  frame->frameIndex = ++frames_;
  frame->videoMode = mode_;
  frame->width = mode_.resolutionX;
  frame->height = mode_.resolutionY;
  frame->cropOriginX = frame->cropOriginY = 0;
  frame->croppingEnabled = FALSE;
  frame->sensorType = sensor_;
  frame->timestamp = static_cast<std::uint64_t>(stamp.count());
  frame->stride = mode_.resolutionX * (depth ? 2 : bytes_of(mode_.pixelFormat));
  frame->dataSize = frame->stride * mode_.resolutionY;
  if (depth) {
    copy_rows(feed.depth(device_.file().hundred_um, device_.registered()), 1, frame->data);
  } else if (mode_.pixelFormat == ONI_PIXEL_FORMAT_RGB888) {
    copy_rows(feed.rgb(), 3, frame->data);
  } else {
    std::vector<std::uint8_t> turned(feed.rgb().size());
    copy_rows(feed.rgb(), 3, turned.data());
    put_pixels(mode_.pixelFormat, turned, frame->data);
  }
  raiseNewFrame(frame);
  getServices().releaseFrame(frame);
}

}  // namespace onemap::test
