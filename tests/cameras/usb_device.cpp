#include "usb_device.hpp"

#include <algorithm>

namespace onemap::test {

namespace {

constexpr std::uint8_t kStandard = 0, kKindMask = 0x60, kIn = 0x80;
constexpr std::uint8_t kGetStatus = 0, kClearFeature = 1, kGetDescriptor = 6, kGetConfiguration = 8, kGetInterface = 10;
constexpr int kDevice = 1, kConfiguration = 2, kString = 3;
constexpr int kEnglish = 0x0409;

Setup setup_of(const Urb& urb) {
  const auto& s = urb.setup;
  const auto word = [&](std::size_t i) { return static_cast<std::uint16_t>(s[i] | s[i + 1] << 8); };
  return {s[0], s[1], word(2), word(4), word(6)};
}

}  // namespace

void put16(Bytes& into, unsigned value) {
  into.push_back(static_cast<std::uint8_t>(value));
  into.push_back(static_cast<std::uint8_t>(value >> 8));
}

void put32(Bytes& into, std::uint32_t value) {
  put16(into, value & 0xffff);
  put16(into, value >> 16);
}

void append(Bytes& into, const Bytes& more) { into.insert(into.end(), more.begin(), more.end()); }

void UsbDevice::plug(UsbPort& port) {
  waiting_.clear();
  speed_ = port.speed();
  forget();
  port.plug();
}

Bytes UsbDevice::descriptors(UsbPort::Speed speed) const {
  Bytes out = device_descriptor(speed);
  append(out, configuration(speed));
  return out;
}

void UsbDevice::handle(const UsbPort::Request& request, UsbPort& port) {
  if (!request.urb) return take_back(request, port);
  if (request.urb->endpoint == 0) return answer_control(*request.urb, port);
  waiting_[request.urb->endpoint].push_back(*request.urb);
}

void UsbDevice::take_back(const UsbPort::Request& request, UsbPort& port) {
  for (auto& [endpoint, urbs] : waiting_) {
    const auto found = std::ranges::find(urbs, request.taken_back, &Urb::number);
    if (found == urbs.end()) continue;
    urbs.erase(found);
    if (urbs.empty()) stopped(endpoint);
    return port.give_back(request, true);
  }
  port.give_back(request, false);
}

void UsbDevice::answer_control(const Urb& urb, UsbPort& port) {
  const Setup setup = setup_of(urb);
  const auto answer = (setup.type & kKindMask) == kStandard ? standard(setup) : control(setup, urb.out);
  if (!answer) return port.refuse(urb);
  port.answer(urb, std::span(*answer).first(std::min<std::size_t>(answer->size(), setup.length)));
}

std::optional<Bytes> UsbDevice::standard(const Setup& setup) const {
  if (setup.request == kGetDescriptor) return descriptor(setup);
  if (setup.request == kGetStatus) return Bytes{0, 0};
  if (setup.request == kGetConfiguration) return Bytes{1};
  if (setup.request == kGetInterface) return Bytes{0};
  if (setup.type & kIn) return std::nullopt;
  return Bytes{};  // addresses, configurations, interfaces, halts, features: as you like
}

std::optional<Bytes> UsbDevice::descriptor(const Setup& setup) const {
  const int kind = setup.value >> 8, index = setup.value & 255;
  if (kind == kDevice) return device_descriptor(speed_);
  if (kind == kConfiguration) return configuration(speed_);
  if (kind != kString) return std::nullopt;
  Bytes out{0, kString};
  if (index == 0)
    put16(out, kEnglish);
  else
    for (const char c : text(index)) put16(out, static_cast<unsigned char>(c));
  if (out.size() == 2) return std::nullopt;
  out[0] = static_cast<std::uint8_t>(out.size());
  return out;
}

}  // namespace onemap::test
