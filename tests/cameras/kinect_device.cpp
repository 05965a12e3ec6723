#include "kinect_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "support/kinect_session.hpp"

namespace onemap::test {

namespace {

// What libfreenect makes of them: z = reference * (30 / pixel) / (1090 - disparity), OpenKinect's numbers.
constexpr unsigned kConstShift = 200;
constexpr float kEmitter_cm = 7.5F, kColour_cm = 2.3F, kPixel_mm = 0.103986F, kReference_cm = 120.624F;
constexpr double kColourOfLibrary_cm = 2.4;  // libfreenect does not believe the device here
constexpr int kNoDisparity = 2047;
constexpr std::size_t kWidth = 640, kHeight = 480, kPixels = kWidth * kHeight;

constexpr std::size_t kZeroPlaneBytes = 322, kZeroPlaneOffset = 94, kRegistrationBytes = 118;
constexpr std::uint8_t kVendorOut = 0x40, kVendorIn = 0xc0;
constexpr unsigned kFixedParameters = 0x04, kReadRegister = 0x02, kWriteRegister = 0x03, kParameters = 0x16;
constexpr unsigned kColourStream = 0x05, kDepthStream = 0x06;
constexpr std::uint8_t kFirst = 1, kMiddle = 2, kLast = 5;
constexpr std::size_t kPacketHeader = 12;
constexpr auto kSending = std::chrono::milliseconds(25);  // of 33: a picture's packets come spread

unsigned word(std::span<const std::uint8_t> bytes, std::size_t at) {
  return at + 1 < bytes.size() ? bytes[at] | static_cast<unsigned>(bytes[at + 1]) << 8 : 0;
}

void put_float(Bytes& into, std::size_t at, float value) { std::memcpy(&into[at], &value, sizeof value); }

// A clock of 60 MHz that turns over.
std::uint32_t ticks_of(std::chrono::nanoseconds stamp) {
  const auto ns = static_cast<std::uint64_t>(stamp.count());
  return static_cast<std::uint32_t>(ns / 50 * 3 + ns % 50 * 3 / 50);
}

// Green red, blue green.
Bytes mosaic_of(std::span<const std::uint8_t> rgb) {
  Bytes out(kPixels);
  for (std::size_t y = 0; y < kHeight; ++y)
    for (std::size_t x = 0; x < kWidth; ++x) {
      const std::size_t channel = (x + y) % 2 == 0 ? 1 : y % 2 == 0 ? 0 : 2;
      out[y * kWidth + x] = rgb[3 * (y * kWidth + x) + channel];
    }
  return out;
}

// By disparity, how many pixels registration moves it to the right, as libfreenect computes depth and shift.
std::vector<int> shifts() {
  std::vector<int> out(kNoDisparity, 0);
  const double scale = 1 / (static_cast<double>(kPixel_mm) * 2 * 10);
  for (int raw = 0; raw < kNoDisparity; ++raw) {
    const double metric = ((raw - 4.0 * kConstShift) / 4 - 0.375) * kPixel_mm;
    const double mm = std::trunc(10 * (metric * kReference_cm / (kEmitter_cm - metric) + kReference_cm));
    if (mm < 1) continue;
    const double shift = kColourOfLibrary_cm * scale * 10 * (mm - 10.0 * kReference_cm) / mm + 0.375;
    out[static_cast<std::size_t>(raw)] = static_cast<int>(std::floor(std::trunc(shift * 256) / 256));
  }
  return out;
}

Bytes packed(const std::vector<std::uint16_t>& disparities) {  // 11 bits each, the high bits first
  Bytes out;
  out.reserve(disparities.size() * 11 / 8);
  std::uint32_t bits = 0;
  int count = 0;
  for (const std::uint16_t raw : disparities) {
    bits = bits << 11 | raw;
    for (count += 11; count >= 8; count -= 8) out.push_back(static_cast<std::uint8_t>(bits >> (count - 8)));
  }
  return out;
}

// Where the depth camera saw what colour sees; what is nearer hides.
Bytes disparities_of(const hal::FrameView& frame) {
  static const std::vector<int> shift_px = shifts();
  std::vector<std::uint16_t> seen(kPixels, kNoDisparity);
  for (std::size_t i = 0; i < kPixels; ++i) {
    const std::uint16_t raw = kinect_disparity(frame.depth[i] / frame.intrinsics->depth_scale);
    if (raw >= kNoDisparity) continue;
    const int x = static_cast<int>(i % kWidth) - shift_px[raw];
    if (x < 0 || x >= static_cast<int>(kWidth)) continue;
    std::uint16_t& there = seen[i - i % kWidth + static_cast<std::size_t>(x)];
    there = std::min(there, raw);
  }
  return packed(seen);
}

}  // namespace

KinectDevice::KinectDevice(const Film& film, Projector& projector, std::string serial)
    : film_(film), projector_(projector), serial_(std::move(serial)) {
  if (film.width() != kWidth || film.height() != kHeight) throw std::runtime_error("a Kinect's film has 640x480");
}

Film::Picture KinectDevice::develop(const hal::FrameView& frame) {
  return {disparities_of(frame), mosaic_of(frame.rgb)};
}

Bytes KinectDevice::device_descriptor(UsbPort::Speed) const {
  return {18, 1, 0x00, 0x02, 0, 0, 0, 64, 0x5e, 0x04, 0xae, 0x02, 0x0b, 0x01, 1, 2, 3, 1};
}

Bytes KinectDevice::configuration(UsbPort::Speed) const {
  return {9,    2, 32, 0, 1,    1, 0,    0xc0, 250, 9, 4, 0,    0, 2,    0xff, 0xff,
          0xff, 0, 7,  5, 0x81, 1, 0xc0, 0x0b, 1,   7, 5, 0x82, 1, 0xc0, 0x0b, 1};
}

std::string KinectDevice::text(int index) const {
  return index == 1 ? "Microsoft" : index == 2 ? "Xbox NUI Camera" : index == 3 ? serial_ : "";
}

std::optional<Bytes> KinectDevice::control(const Setup& setup, std::span<const std::uint8_t> out) {
  if (setup.type == kVendorOut) {
    command(out);
    return Bytes{};
  }
  if (setup.type == kVendorIn) return reply_;
  return std::nullopt;
}

// "GM", words of arguments, command, tag; the answer is "RB", words, command, tag.
void KinectDevice::command(std::span<const std::uint8_t> out) {
  const unsigned code = word(out, 4);
  Bytes data(2, 0);
  if (code == kFixedParameters || code == kParameters) data = parameters(code == kParameters ? word(out, 8) : ~0U);
  if (code == kReadRegister) data.resize(4);
  if (code == kWriteRegister) write_register(word(out, 8), word(out, 10));
  reply_ = {0x52, 0x42};
  put16(reply_, static_cast<unsigned>(data.size() / 2));
  put16(reply_, code);
  put16(reply_, word(out, 6));
  append(reply_, data);
}

// Registration that takes libfreenect's own offset of one pixel back and moves by the parallax alone.
Bytes KinectDevice::parameters(unsigned which) const {
  constexpr std::size_t kDxStart = 2 + 5 * 4, kDyStart = 2 + 10 * 4;
  constexpr std::int32_t kOnePixel = -256;
  if (which == 0x00) {
    Bytes out{0, 0};
    put16(out, kConstShift);
    return out;
  }
  if (which == 0x41) return Bytes(8, 0);
  if (which == 0x40) {
    Bytes out(kRegistrationBytes, 0);
    std::memcpy(&out[kDxStart], &kOnePixel, sizeof kOnePixel);
    std::memcpy(&out[kDyStart], &kOnePixel, sizeof kOnePixel);
    return out;
  }
  Bytes out(kZeroPlaneBytes, 0);
  std::size_t at = kZeroPlaneOffset;
  for (const float value : {kEmitter_cm, kColour_cm, kReference_cm, kPixel_mm}) {
    put_float(out, at, value);
    at += sizeof value;
  }
  return out;
}

void KinectDevice::write_register(unsigned number, unsigned value) {
  if (number == kColourStream) colour_.wanted = value == 1;
  if (number == kDepthStream) depth_.wanted = value == 2;
}

void KinectDevice::forget() {
  for (Stream* stream : {&depth_, &colour_}) {
    stream->wanted = false;
    stream->image.clear();
    stream->sent = 0;
  }
  projector_.stop();
}

void KinectDevice::stopped(int endpoint) { (endpoint == depth_.endpoint ? depth_ : colour_).wanted = false; }

void KinectDevice::load(Stream& stream, const Bytes& image) {
  if (stream.sent < stream.image.size()) fmt::print("late {} {}\n", stream.endpoint, projector_.number());
  stream.image = image;
  stream.sent = 0;
}

Bytes KinectDevice::packet(Stream& stream) const {
  const std::size_t bytes = std::min(stream.packet_bytes, stream.image.size() - stream.sent);
  const bool first = stream.sent == 0, last = stream.sent + bytes == stream.image.size();
  const std::uint8_t place = first ? kFirst : last ? kLast : kMiddle;
  Bytes out{'R', 'B', 0, static_cast<std::uint8_t>(stream.flag | place), 0, stream.sequence, 0, 0};
  put32(out, ticks_);
  const auto from = stream.image.begin() + static_cast<std::ptrdiff_t>(stream.sent);
  out.insert(out.end(), from, from + static_cast<std::ptrdiff_t>(bytes));
  return out;
}

void KinectDevice::send(Stream& stream, Moment now, UsbPort& port) {
  auto& urbs = waiting(stream.endpoint);
  const auto share = std::chrono::duration<double>(now - projector_.since()) / kSending;
  const auto due = static_cast<std::size_t>(std::clamp(share, 0.0, 1.0) * static_cast<double>(stream.packets()));
  while (!urbs.empty() && stream.sent < stream.image.size()) {
    const std::size_t wanted = std::min(urbs.front().packets.size(), stream.packets() - stream.packets_sent());
    if (stream.packets_sent() + wanted > due) return;
    const Urb urb = std::move(urbs.front());
    urbs.pop_front();
    std::vector<Bytes> packets;
    while (packets.size() < wanted) {
      packets.push_back(packet(stream));
      ++stream.sequence;
      stream.sent += packets.back().size() - kPacketHeader;
    }
    port.answer_packets(urb, packets);
  }
}

void KinectDevice::step(Moment now, UsbPort& port) {
  if (projector_.advance(depth_.wanted && colour_.wanted, now)) {
    ticks_ = ticks_of(projector_.stamp());
    const Film::Picture& picture = film_.pictures()[projector_.number()];
    load(depth_, picture.depth);
    load(colour_, picture.colour);
  }
  send(depth_, now, port);
  send(colour_, now, port);
}

Moment KinectDevice::next_step() const {
  const bool sending = depth_.sent < depth_.image.size() || colour_.sent < colour_.image.size();
  const Moment soon = std::chrono::steady_clock::now() + std::chrono::milliseconds(2);
  return sending ? std::min(soon, projector_.next()) : projector_.next();
}

}  // namespace onemap::test
