#include "libusb_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <utility>

#include "hal/base/text.hpp"
#include "hal/imaging/raw_colour.hpp"

namespace onemap::hal::libusb {

namespace {

using std::chrono::milliseconds;

// Half a frame's time at 30 Hz: an image's partner is never farther.
constexpr Duration kMaxApart = std::chrono::microseconds(17000);
constexpr milliseconds kLook{20};  // so often a wait looks whether the device has left
constexpr milliseconds kLookAnew{1000};
constexpr double kDepthFocal_px = 580, kMillimetres = 1000;

}  // namespace

LibusbCamera::LibusbCamera(Address address, std::unique_ptr<Usb> usb, std::unique_ptr<Freenect> freenect)
    : address_(std::move(address)),
      usb_(std::move(usb)),
      freenect_(std::move(freenect)),
      pairs_(std::in_place, kMaxApart, kWaiting),
      clock_(address_.clock_offset) {}

Result<std::unique_ptr<DepthCamera>> LibusbCamera::open(Address address) {
  auto usb = Usb::open();
  if (!usb) return usb.error();
  auto freenect = Freenect::start(**usb);
  if (!freenect) return freenect.error();
  std::unique_ptr<LibusbCamera> camera(new LibusbCamera(std::move(address), std::move(*usb), std::move(*freenect)));
  if (const Status status = camera->connect_named(); !status) return status.error();
  if (const Status status = camera->prepare(); !status) return status.error();
  return std::unique_ptr<DepthCamera>(std::move(camera));
}

namespace {
std::string serials_of(const std::vector<Plugged>& kinects) {
  std::string text;
  for (const Plugged& one : kinects)
    text += (text.empty() ? "; there is " : ", ") + (one.serial.empty() ? std::string("one without") : one.serial);
  return printable(text);
}
}  // namespace

// libfreenect may see a device that is not on the bus: fakenect's.
Status LibusbCamera::connect_named() {
  const std::string& serial = address_.serial;
  const std::vector<Plugged> all = usb_->kinects();
  const auto wanted = [&](const Plugged& k) { return serial.empty() || k.serial == serial; };
  auto found = std::ranges::find_if(all, [&](const Plugged& k) { return wanted(k) && k.problem.empty(); });
  if (found == all.end()) found = std::ranges::find_if(all, wanted);  // to say what is wrong with it
  if (found == all.end() && all.empty() && freenect_->devices() > 0)
    return freenect_->open(0, address_.lenses.registration);
  if (found == all.end())
    return Error{"camera address '" + address_.text + "'",
                 serial.empty() ? std::string("no Kinect is connected")
                                : "no Kinect with this serial number is connected" + serials_of(all)};
  if (!found->problem.empty())
    return Error{fmt::format("camera libusb: (bus {} device {})", found->bus, found->address), found->problem};
  model_ = found->model();
  return connect(all, static_cast<std::size_t>(found - all.begin()));
}

Status LibusbCamera::connect(const std::vector<Plugged>& all, std::size_t index) {
  ours_ = all[index];
  beside_ = all;
  std::erase_if(beside_, [&](const Plugged& k) { return k.same_stay(ours_); });
  usb_->watch(ours_.bus, ours_.address);
  return freenect_->open(static_cast<int>(index), address_.lenses.registration);
}

// Serial numbers do not tell all Kinects apart: many have none, or that of others. One that was there when ours was
// opened is another; of several that came, ours is the one at its port.
std::optional<std::size_t> LibusbCamera::ours_among(const std::vector<Plugged>& all) const {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Plugged& one = all[i];
    const bool another = std::ranges::any_of(beside_, [&](const Plugged& other) { return one.same_stay(other); });
    if (another || !one.problem.empty() || one.serial != ours_.serial) continue;
    if (!found || one.same_socket(ours_)) found = i;
  }
  return found;
}

Status LibusbCamera::prepare() {
  colour_ = Intrinsics{};
  colour_.depth_scale = kMillimetres;
  if (address_.lenses.calibration.has_lens())
    if (const Status status = address_.lenses.calibration.apply(colour_); !status) return status.error();
  const imaging::Registration registration = freenect_->registration();
  mm_.resize(kSize.pixels());
  if (registration == imaging::Registration::ours) {
    Intrinsics depth;
    depth.fx = depth.fy = kDepthFocal_px;
    depth.depth_scale = colour_.depth_scale;
    const imaging::ColourFromDepth pose{.translation_m = {-address_.lenses.baseline_m, 0, 0}};
    registration_ = std::make_unique<imaging::DepthRegistration>(depth, colour_, pose);
  }
  const std::string_view source = address_.lenses.calibration_source;
  description_ = printable(fmt::format("{} by libusb{}{}, 640x480, depth {}, calibration: {}", model_,
                                       ours_.serial.empty() ? "" : ", serial number ", ours_.serial,
                                       to_string(registration), source.empty() ? "nominal, 525 px" : source));
  return success();
}

CameraCounters LibusbCamera::counters() const {
  CameraCounters all = counters_;
  all.unmatched += pairs_->unmatched();
  return all;
}

Grab LibusbCamera::grab(Frame& into, milliseconds timeout) {
  return freenect_->is_open() ? grab_connected(into, timeout) : grab_gone(into, timeout);
}

// Nothing reads a clock here: a wait that found nothing took its time, and one that found an image took none.
Grab LibusbCamera::grab_connected(Frame& into, milliseconds timeout) {
  for (milliseconds left = timeout;;) {
    Outcome pair;
    if (next_pair(pair)) return deliver(pair, into);
    const milliseconds wait = std::clamp(left, milliseconds(0), kLook);
    if (const auto image = freenect_->images().take(wait)) {
      take(*image);
      continue;
    }
    if (freenect_->lost()) return lose_device("was disconnected");
    left -= wait;
    if (left <= left.zero()) return stall_.waited(timeout) ? stalled() : Grab::timeout;
  }
}

// Nobody said that it left: the USB was reset, or its transfers died.
Grab LibusbCamera::stalled() {
  const bool listed = std::ranges::any_of(usb_->kinects(), [&](const Plugged& k) { return k.same_stay(ours_); });
  return lose_device(
      fmt::format("gave nothing for {} s{}", Stall::kAfter / milliseconds(1000),
                  listed ? " though it is still connected; it is opened again" : ", and is not there any more"),
      Stall::kAfter);
}

Grab LibusbCamera::lose_device(const std::string& why, milliseconds silent) {
  error_ = Error{"camera libusb:" + printable(ours_.serial), why};
  counters_.unmatched += pairs_->unmatched();
  pairs_.emplace(kMaxApart, kWaiting);
  freenect_->close();
  away_ = looked_at_ = silent;
  return Grab::gone;
}

Grab LibusbCamera::grab_gone(Frame& into, milliseconds timeout) {
  const bool back = reconnect() || (usb_->wait_for_arrival(timeout) && reconnect());
  if (back) return grab_connected(into, timeout);
  away_ += timeout;
  if (away_ - looked_at_ >= kLookAnew) look_anew();
  return Grab::gone;
}

// libusb hears of arrivals from udev's daemon. Where there is none (many containers) its list of the bus stays as it
// was when it began: whoever begins now sees what is there.
void LibusbCamera::look_anew() {
  looked_at_ = away_;
  auto usb = Usb::open();
  if (!usb || !ours_among((*usb)->kinects())) return;
  auto freenect = Freenect::start(**usb);
  if (!freenect) return;
  freenect_ = std::move(*freenect);
  usb_ = std::move(*usb);
}

bool LibusbCamera::reconnect() {
  const std::vector<Plugged> all = usb_->kinects();
  const auto index = ours_among(all);
  if (!index) return false;
  if (const Status status = connect(all, *index); !status) {
    error_ = status.error();
    return false;
  }
  ticks_ = Ticks();
  clock_.came_back(away_);
  next_number_ = 0;
  return true;
}

void LibusbCamera::take(const ImageRing::Image& image) {
  if (image.stream == Stream::colour) {
    counters_.missed += image.number - next_number_;
    index_ += image.number + 1 - next_number_;
    next_number_ = image.number + 1;
    indices_[image.slot] = index_ - 1;
  }
  held(image.stream, image.slot) = image;
  const imaging::PairByTime::Image named{clock_.at(ticks_.at(image.ticks)), image.slot};
  if (image.stream == Stream::colour ? pairs_->add_colour(named) : pairs_->add_depth(named)) return;
  freenect_->images().give_back(image);
  ++counters_.unmatched;
}

bool LibusbCamera::next_pair(Outcome& pair) {
  using Kind = imaging::PairByTime::Kind;
  for (;;) {
    pair = pairs_->next();
    if (pair.kind == Kind::nothing) return false;
    if (pair.kind == Kind::pair) return true;
    const bool colour = pair.kind == Kind::lone_colour;
    freenect_->images().give_back(
        held(colour ? Stream::colour : Stream::depth, colour ? pair.colour.buffer : pair.depth.buffer));
  }
}

Grab LibusbCamera::deliver(const Outcome& pair, Frame& into) {
  ImageRing& images = freenect_->images();
  const ImageRing::Image colour = held(Stream::colour, pair.colour.buffer);
  const ImageRing::Image depth = held(Stream::depth, pair.depth.buffer);
  write_colour(images.bytes(colour), into.rgb());
  write_depth(images.bytes(depth), into.depth());
  images.give_back(colour);
  images.give_back(depth);
  into.index = indices_[pair.colour.buffer];
  into.colour_time = pair.colour.time;
  into.depth_time = pair.depth.time;
  stall_.came();
  ++counters_.frames;
  return Grab::frame;
}

// The ring's images are as long as the modes say: nothing here can be too short.
void LibusbCamera::write_colour(std::span<const std::uint8_t> bytes, std::span<std::uint8_t> rgb) const {
  if (!freenect_->forms().mosaic) {
    std::memcpy(rgb.data(), bytes.data(), rgb.size());
    return;
  }
  [[maybe_unused]] const Status status = imaging::bayer_grbg_to_rgb({bytes, kSize}, rgb);
  assert(status.ok());
}

void LibusbCamera::write_depth(std::span<const std::uint8_t> bytes, std::span<std::uint16_t> depth) {
  Status status = success();
  if (imaging::TabledRegistration* factory = freenect_->factory()) {
    status = factory->apply(bytes, depth);
    assert(status.ok());
    return;
  }
  const std::span<std::uint16_t> mm = registration_ ? std::span(mm_) : depth;
  if (freenect_->forms().packed)
    status = to_mm_.packed_to_mm({bytes, kSize}, mm);
  else
    to_mm_.to_mm({reinterpret_cast<const std::uint16_t*>(bytes.data()), mm.size()}, mm);
  assert(status.ok());
  if (registration_) registration_->apply(mm, depth);
}

}  // namespace onemap::hal::libusb
