#include "openni2_camera.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "hal/backends/openni2/decode.hpp"
#include "hal/base/text.hpp"

namespace onemap::hal::openni2 {

namespace {

using std::chrono::milliseconds;

// Half a frame's time at 30 Hz: an image's partner is never farther.
constexpr Duration kMaxApart = std::chrono::microseconds(17000);
// A device that was pulled out is silent, and only a callback tells: so often it is asked for.
constexpr milliseconds kLook{20};
// Longer than any disk takes: a recording that is silent for so long is broken.
constexpr milliseconds kRecordingPatience{5000};
constexpr milliseconds kLookAnew{3000};

}  // namespace

OpenNi2Camera::OpenNi2Camera(Address address, std::shared_ptr<Library> library, std::unique_ptr<Hotplug> hotplug)
    : address_(std::move(address)),
      library_(std::move(library)),
      hotplug_(std::move(hotplug)),
      pairs_(std::in_place, kMaxApart, kWaiting),
      clock_(address_.file ? Duration{} : address_.clock_offset) {}

Result<std::unique_ptr<DepthCamera>> OpenNi2Camera::open(Address address) {
  auto library = Library::load();
  if (!library) return library.error();
  auto hotplug = Hotplug::listen();
  if (!hotplug) return hotplug.error();
  std::unique_ptr<OpenNi2Camera> camera(
      new OpenNi2Camera(std::move(address), std::move(*library), std::move(*hotplug)));
  if (const Status status = camera->connect(); !status) return status.error();
  return std::unique_ptr<DepthCamera>(std::move(camera));
}

Status OpenNi2Camera::connect() {
  std::string uri = address_.uri;
  if (uri.empty()) {
    const auto devices = connected_devices();
    if (devices.empty())
      return Error{"camera address '" + address_.text + "'", "no device that OpenNI2's drivers know is connected"};
    uri = devices.front().getUri();
  }
  if (address_.file && access(uri.c_str(), R_OK) != 0)  // the library would not say why
    return Error{printable("camera " + uri), std::string("cannot be read: ") + std::strerror(errno)};
  hotplug_->watch(uri);
  auto device = Device::open(address_, uri);
  if (!device) return device.error();
  device_ = std::move(*device);
  identity_ = device_->identity();
  colour_ = device_->colour();
  if (device_->registration() == imaging::Registration::ours) {
    const imaging::ColourFromDepth pose{.translation_m = {-address_.lenses.baseline_m, 0, 0}};
    registration_ = std::make_unique<imaging::DepthRegistration>(device_->depth(), colour_, pose);
    unregistered_.resize(imaging::size_of(colour_).pixels());
  }
  opened();
  return success();
}

void OpenNi2Camera::opened() {
  beside_.clear();
  for (const openni::DeviceInfo& info : connected_devices())
    if (info.getUri() != identity_.uri) beside_.emplace_back(info.getUri());
  describe();
}

void OpenNi2Camera::describe() {
  const std::string_view fallback =
      device_->colour_is_nominal() ? "nominal, 525 px at 640" : "the device's field of view";
  const std::string_view source = address_.lenses.calibration_source;
  description_ = printable(fmt::format(
      "OpenNI2 {} {}{}{}, depth {} ({}), colour {}, calibration: {}", identity_.name, identity_.uri,
      identity_.serial.empty() ? "" : ", serial number ", identity_.serial, to_string(device_->modes().depth),
      to_string(device_->registration()), to_string(device_->modes().colour), source.empty() ? fallback : source));
}

CameraCounters OpenNi2Camera::counters() const {
  CameraCounters all = counters_;
  all.unmatched += pairs_->unmatched();
  return all;
}

std::uint64_t OpenNi2Camera::frames_expected() const {
  if (!address_.file || !device_) return 0;
  const std::uint64_t seen = counters_.frames + counters_.bad;
  return device_->recorded_frames() - std::min(seen, device_->recorded_frames());
}

Grab OpenNi2Camera::grab(Frame& into, milliseconds timeout) {
  return device_ ? grab_connected(into, timeout) : grab_gone(into, timeout);
}

// Nothing reads a clock here: a wait that found nothing took its time, and one that found an image took none.
Grab OpenNi2Camera::grab_connected(Frame& into, milliseconds timeout) {
  for (milliseconds left = timeout;;) {
    imaging::PairByTime::Outcome pair;
    if (next_pair(pair)) return deliver(pair, into);
    if (hotplug_->left()) return lose_device("was disconnected");
    if (over_ || device_->played_to_the_end()) return Grab::end;
    const milliseconds wait = std::clamp(left, milliseconds(1), kLook);
    openni::VideoFrameRef image;
    const Device::Image kind = device_->read(image, wait);
    if (kind == Device::Image::broken)
      return hotplug_->left() ? lose_device("was disconnected") : broken(device_->last_error());
    if (kind != Device::Image::none) {
      silent_ = {};
      take(kind, image);
      continue;
    }
    if (address_.file && (silent_ += wait) >= kRecordingPatience)
      return broken(Error{printable("camera " + identity_.uri), "gives no images before its end"});
    left -= wait;
    if (left <= left.zero()) return !address_.file && stall_.waited(timeout) ? stalled() : Grab::timeout;
  }
}

// A device may give the next image, a recording will not.
Grab OpenNi2Camera::broken(const Error& error) {
  over_ = address_.file;
  error_ = error;
  ++counters_.bad;
  return Grab::bad;
}

// No driver said that it left: the USB was reset, or it hangs.
Grab OpenNi2Camera::stalled() {
  const auto devices = connected_devices();
  const bool listed = std::ranges::any_of(devices, [&](const auto& d) { return identity_.may_be(identity_of(d)); });
  return lose_device(
      fmt::format("gave nothing for {} s{}", Stall::kAfter / milliseconds(1000),
                  listed ? " though it is still connected; it is opened again" : ", and is not there any more"),
      Stall::kAfter);
}

Grab OpenNi2Camera::lose_device(const std::string& why, milliseconds silent) {
  error_ = Error{printable("camera " + identity_.uri), why};
  counters_.unmatched += pairs_->unmatched();
  pairs_.emplace(kMaxApart, kWaiting);
  for (openni::VideoFrameRef& image : held_) image.release();
  device_.reset();
  away_ = looked_at_ = silent;
  return Grab::gone;
}

Grab OpenNi2Camera::grab_gone(Frame& into, milliseconds timeout) {
  if (!hotplug_) std::this_thread::sleep_for(timeout);
  const bool back = hotplug_ && (reconnect() || (hotplug_->wait_for_arrival(timeout) && reconnect()));
  if (back) return grab_connected(into, timeout);
  away_ += timeout;
  if (away_ - looked_at_ >= kLookAnew) look_anew();
  return Grab::gone;
}

// The drivers look for devices when they begin, and then hear of them from udev's daemon. Where there is none (many
// containers) they hear of nothing: who begins now sees what is there. While another camera uses them they go on.
void OpenNi2Camera::look_anew() {
  looked_at_ = away_;
  hotplug_.reset();
  library_.reset();
  auto library = Library::load();
  auto hotplug = library ? Hotplug::listen() : Result<std::unique_ptr<Hotplug>>(library.error());
  if (!hotplug) {
    error_ = hotplug.error();
    return;
  }
  library_ = std::move(*library);
  hotplug_ = std::move(*hotplug);
}

bool OpenNi2Camera::reconnect() {
  for (const openni::DeviceInfo& info : connected_devices()) {
    const Identity found = identity_of(info);
    if (!identity_.may_be(found) || std::ranges::find(beside_, found.uri) != beside_.end()) continue;
    hotplug_->watch(found.uri);
    auto device = Device::open(address_, found.uri);
    if (!device) {
      error_ = device.error();
      continue;
    }
    if (!identity_.may_be((*device)->identity()) || (*device)->colour() != colour_) continue;
    device_ = std::move(*device);
    identity_.uri = device_->identity().uri;  // another socket has another
    opened();
    clock_.came_back(away_);
    last_frame_index_ = 0;
    return true;
  }
  return false;
}

void OpenNi2Camera::take(Device::Image kind, openni::VideoFrameRef& image) {
  const bool colour = kind == Device::Image::colour;
  if (colour) count_colour(image.getFrameIndex());
  std::size_t& slot = next_slot_[colour ? 1 : 0];
  // Twice as many slots as may wait: one is not used again while its image waits or is in the pair being delivered.
  const auto buffer = static_cast<std::uint32_t>(slot + (colour ? 2 * kWaiting : 0));
  const Image named{clock_.at(std::chrono::microseconds(image.getTimestamp())), buffer};
  if (!(colour ? pairs_->add_colour(named) : pairs_->add_depth(named))) {
    ++counters_.unmatched;
    return;
  }
  held_[buffer] = image;
  numbers_[buffer] = index_;
  slot = (slot + 1) % (2 * kWaiting);
}

bool OpenNi2Camera::next_pair(imaging::PairByTime::Outcome& pair) {
  using Kind = imaging::PairByTime::Kind;
  for (;;) {
    pair = pairs_->next();
    if (pair.kind == Kind::nothing) return false;
    if (pair.kind == Kind::pair) return true;
    held(pair.kind == Kind::lone_colour ? pair.colour : pair.depth).release();
  }
}

Grab OpenNi2Camera::deliver(const imaging::PairByTime::Outcome& pair, Frame& into) {
  stall_.came();
  into.index = numbers_[pair.colour.buffer] - 1;
  const Status status = decode(pair, into);
  held(pair.colour).release();
  held(pair.depth).release();
  if (!status) {
    error_ = status.error();
    ++counters_.bad;
    return Grab::bad;
  }
  into.colour_time = pair.colour.time;
  into.depth_time = pair.depth.time;
  ++counters_.frames;
  return Grab::frame;
}

// The device numbers its images from 1, those that nobody fetched as well.
void OpenNi2Camera::count_colour(int frame_index) {
  const int step = last_frame_index_ == 0 ? 1 : std::max(1, frame_index - last_frame_index_);
  last_frame_index_ = frame_index;
  counters_.missed += static_cast<std::uint64_t>(step) - 1;
  index_ += static_cast<std::uint64_t>(step);
}

namespace {
imaging::RawImage raw(const openni::VideoFrameRef& image) {
  return {{static_cast<const std::uint8_t*>(image.getData()), static_cast<std::size_t>(image.getDataSize())},
          {image.getWidth(), image.getHeight()},
          static_cast<std::size_t>(image.getStrideInBytes())};
}
}  // namespace

Status OpenNi2Camera::decode(const imaging::PairByTime::Outcome& pair, Frame& into) {
  const auto place = [&](std::string_view what) {
    return printable(fmt::format("camera {}: {} image {}", identity_.uri, what, into.index));
  };
  const imaging::RawImage colour = raw(held(pair.colour)), depth = raw(held(pair.depth));
  if (colour.size != imaging::size_of(colour_) || depth.size != imaging::size_of(colour_))
    return Error{place("the"),
                 fmt::format("depth {}x{}, colour {}x{} where both were set to {}x{}", depth.size.width,
                             depth.size.height, colour.size.width, colour.size.height, colour_.width, colour_.height)};
  if (const Status status =
          decode_colour(device_->modes().colour.format, colour, device_->colour_mirrored(), into.rgb());
      !status)
    return Error{place("colour"), status.error().reason};
  if (const Status status = fill_depth(depth, into.depth()); !status)
    return Error{place("depth"), status.error().reason};
  return success();
}

Status OpenNi2Camera::fill_depth(const imaging::RawImage& image, std::span<std::uint16_t> depth) {
  if (device_->registration() != imaging::Registration::ours)
    return decode_depth(image, device_->depth_mirrored(), depth);
  const std::size_t row_bytes = 2 * static_cast<std::size_t>(image.size.width);
  if (Status status = imaging::check_rows(image, row_bytes); !status) return status;
  if (!device_->depth_mirrored() && image.stride(row_bytes) == row_bytes) {  // it needs no copy
    registration_->apply({reinterpret_cast<const std::uint16_t*>(image.bytes.data()), image.size.pixels()}, depth);
    return success();
  }
  if (Status status = decode_depth(image, device_->depth_mirrored(), unregistered_); !status) return status;
  registration_->apply(unregistered_, depth);
  return success();
}

}  // namespace onemap::hal::openni2
