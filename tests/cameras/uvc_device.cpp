#include "uvc_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace onemap::test {

namespace {

constexpr std::uint32_t kIntervalUnits = 333'333;  // of 100 ns
constexpr std::uint8_t kClassIn = 0xa1, kClassOut = 0x21;
constexpr std::uint8_t kGetLength = 0x85, kGetInfo = 0x86;
constexpr int kProbe = 1, kCommit = 2;
constexpr std::uint8_t kNewImage = 0x01, kLastOfImage = 0x02, kEndOfHeader = 0x80;
constexpr std::size_t kPayloadHeader = 2;

std::uint32_t packet_bytes(UsbPort::Speed speed) { return speed == UsbPort::Speed::super ? 1024 : 512; }
std::uint32_t payload_bytes(UsbPort::Speed speed) { return 32 * packet_bytes(speed); }  // what uvcvideo asks at once

Bytes format_code(const char (&four)[5]) {  // the video class's form of a four-character code
  Bytes out(four, four + 4);
  append(out, {0x00, 0x00, 0x10, 0x00, 0x80, 0x00, 0x00, 0xaa, 0x00, 0x38, 0x9b, 0x71});
  return out;
}

// The control interface of a function: a camera whose pictures go to USB.
Bytes control_interface(int number) {
  const auto n = static_cast<std::uint8_t>(number);
  Bytes out{8, 11, n, 2, 0x0e, 0x03, 0, 0, 9, 4, n, 0, 0, 0x0e, 0x01, 0, 0};
  append(out, {13, 0x24, 1, 0x00, 0x01, 13 + 18 + 9, 0, 0x80, 0x8d, 0x5b, 0x00, 1, static_cast<std::uint8_t>(n + 1)});
  append(out, {18, 0x24, 2, 1, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0});
  append(out, {9, 0x24, 3, 2, 0x01, 0x01, 0, 1, 0});
  return out;
}

Bytes streaming_interface(int number, int endpoint, const Bytes& code, const Film& film, UsbPort::Speed speed) {
  const auto address = static_cast<std::uint8_t>(0x80 | endpoint);
  const std::uint32_t image_bytes = 2 * film.width() * film.height();
  Bytes out{9, 4, static_cast<std::uint8_t>(number), 0, 1, 0x0e, 0x02, 0, 0};
  append(out, {14, 0x24, 1, 1, 14 + 27 + 30, 0, address, 0, 2, 0, 0, 0, 1, 0});
  append(out, {27, 0x24, 4, 1, 1});
  append(out, code);
  append(out, {16, 1, 0, 0, 0, 0});
  append(out, {30, 0x24, 5, 1, 0});
  put16(out, film.width());
  put16(out, film.height());
  put32(out, image_bytes * 8 * 30);
  put32(out, image_bytes * 8 * 30);
  put32(out, image_bytes);
  put32(out, kIntervalUnits);
  out.push_back(1);
  put32(out, kIntervalUnits);
  append(out, {7, 5, address, 2});
  put16(out, packet_bytes(speed));
  out.push_back(0);
  if (speed == UsbPort::Speed::super) append(out, {6, 0x30, 15, 0, 0, 0});
  return out;
}

// BT.601 in video range; two pixels share their colour.
Bytes yuyv_of(std::span<const std::uint8_t> rgb) {
  Bytes out(rgb.size() / 3 * 2);
  const auto part = [](double y, double low, double high) {
    return static_cast<std::uint8_t>(std::clamp(y + 0.5, low, high));
  };
  for (std::size_t i = 0; i < rgb.size() / 3; i += 2) {
    const std::uint8_t* p = &rgb[3 * i];
    double r = 0, g = 0, b = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      out[2 * (i + k)] = part(16 + 0.257 * p[3 * k] + 0.504 * p[3 * k + 1] + 0.098 * p[3 * k + 2], 16, 235);
      r += p[3 * k] / 2.0;
      g += p[3 * k + 1] / 2.0;
      b += p[3 * k + 2] / 2.0;
    }
    out[2 * i + 1] = part(128 - 0.148 * r - 0.291 * g + 0.439 * b, 16, 240);
    out[2 * i + 3] = part(128 + 0.439 * r - 0.368 * g - 0.071 * b, 16, 240);
  }
  return out;
}

}  // namespace

Film::Picture UvcDevice::develop(const hal::FrameView& frame) {
  Bytes depth(2 * frame.depth.size());
  std::memcpy(depth.data(), frame.depth.data(), depth.size());
  return {std::move(depth), yuyv_of(frame.rgb)};
}

// The ids of a RealSense D435, which onemap's udev rules and calibrations know. On USB 2 it calls itself a 2.1 device.
Bytes UvcDevice::device_descriptor(UsbPort::Speed speed) const {
  const bool super = speed == UsbPort::Speed::super;
  Bytes out{18, 1, static_cast<std::uint8_t>(super ? 0x00 : 0x10), static_cast<std::uint8_t>(super ? 3 : 2), 0xef,
            2,  1, static_cast<std::uint8_t>(super ? 9 : 64)};
  append(out, {0x86, 0x80, 0x07, 0x0b, 0x00, 0x01, 1, 2, 3, 1});
  return out;
}

Bytes UvcDevice::configuration(UsbPort::Speed speed) const {
  Bytes rest = control_interface(0);
  append(rest, streaming_interface(1, depth_.endpoint, format_code("Z16 "), film_, speed));
  append(rest, control_interface(2));
  append(rest, streaming_interface(3, colour_.endpoint, format_code("YUY2"), film_, speed));
  Bytes out{9, 2};
  put16(out, static_cast<unsigned>(9 + rest.size()));
  append(out, {4, 1, 0, 0x80, 100});
  append(out, rest);
  return out;
}

std::string UvcDevice::text(int index) const {
  return index == 1 ? "onemap" : index == 2 ? "Virtual depth camera" : index == 3 ? "VM0001" : "";
}

// Every stream has one mode, so that every probe has one answer.
std::optional<Bytes> UvcDevice::control(const Setup& setup, std::span<const std::uint8_t>) {
  const int interface = setup.index & 255, selector = setup.value >> 8;
  if ((interface != 1 && interface != 3) || (selector != kProbe && selector != kCommit)) return std::nullopt;
  if (setup.type == kClassOut) {
    if (selector == kCommit) (interface == 1 ? depth_ : colour_).wanted = true;
    return Bytes{};
  }
  if (setup.type != kClassIn) return std::nullopt;
  if (setup.request == kGetInfo) return Bytes{3};
  if (setup.request == kGetLength) return Bytes{26, 0};
  Bytes mode{1, 0, 1, 1};
  put32(mode, kIntervalUnits);
  mode.resize(18);
  put32(mode, image_bytes());
  put32(mode, payload_bytes(speed()));
  return mode;
}

void UvcDevice::forget() {
  for (Stream* stream : {&depth_, &colour_}) {
    stream->wanted = false;
    stream->image.clear();
    stream->sent = 0;
  }
  projector_.stop();
}

void UvcDevice::stopped(int endpoint) {
  Stream& stream = endpoint == depth_.endpoint ? depth_ : colour_;
  stream.wanted = false;
  stream.image.clear();
  stream.sent = 0;
}

void UvcDevice::load(Stream& stream, const Bytes& image) {
  if (stream.sent < stream.image.size()) {
    fmt::print("late {} {}\n", stream.endpoint, projector_.number());
    return;  // the one before is not through
  }
  stream.image = image;
  stream.sent = 0;
  stream.frame_id ^= kNewImage;
}

void UvcDevice::send(Stream& stream, UsbPort& port) {
  auto& urbs = waiting(stream.endpoint);
  Bytes payload;
  while (!urbs.empty() && stream.sent < stream.image.size()) {
    const Urb urb = std::move(urbs.front());
    urbs.pop_front();
    const std::size_t room = std::min(urb.length, payload_bytes(speed())) - kPayloadHeader;
    const std::size_t bytes = std::min(stream.image.size() - stream.sent, room);
    const bool last = stream.sent + bytes == stream.image.size();
    payload = {kPayloadHeader, static_cast<std::uint8_t>(kEndOfHeader | stream.frame_id | (last ? kLastOfImage : 0))};
    const auto from = stream.image.begin() + static_cast<std::ptrdiff_t>(stream.sent);
    payload.insert(payload.end(), from, from + static_cast<std::ptrdiff_t>(bytes));
    stream.sent += bytes;
    port.answer(urb, payload);
  }
}

void UvcDevice::step(Moment now, UsbPort& port) {
  if (projector_.advance(depth_.wanted && colour_.wanted, now)) {
    const Film::Picture& picture = film_.pictures()[projector_.number()];
    load(depth_, picture.depth);
    load(colour_, picture.colour);
  }
  send(depth_, port);
  send(colour_, port);
}

}  // namespace onemap::test
