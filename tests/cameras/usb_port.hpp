#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace onemap::test {

// A request of the kernel to an endpoint of a device.
struct Urb {
  struct Packet {
    std::uint32_t offset = 0, length = 0;  // in the buffer of `length` bytes
  };
  std::uint32_t number = 0;
  int endpoint = 0;
  bool in = false;
  std::uint32_t length = 0;             // of the buffer
  std::array<std::uint8_t, 8> setup{};  // endpoint 0
  std::vector<std::uint8_t> out;        // what the kernel sends
  std::vector<Packet> packets;          // isochronous
};

// Where a device is plugged in, and what it answers to.
class UsbPort {
 public:
  enum class Speed { full = 2, high = 3, super = 5 };
  struct Request {
    std::optional<Urb> urb;
    std::uint32_t taken_back = 0;  // without an urb: the number of one that the kernel no longer wants
    std::uint32_t number = 0;      // of this request
  };

  explicit UsbPort(Speed speed) : speed_(speed) {}
  virtual ~UsbPort() = default;
  UsbPort(const UsbPort&) = delete;
  UsbPort& operator=(const UsbPort&) = delete;
  Speed speed() const { return speed_; }

  virtual void plug() = 0;
  virtual void answer(const Urb& urb, std::span<const std::uint8_t> data) = 0;  // IN; for OUT: all was taken
  // One span a packet, in the packets' order.
  virtual void answer_packets(const Urb& urb, std::span<const std::vector<std::uint8_t>> packets) = 0;
  virtual void refuse(const Urb& urb) = 0;  // a stall
  virtual void give_back(const Request& request, bool was_waiting) = 0;

 private:
  Speed speed_;
};

// A port of the kernel's virtual host controller (vhci_hcd). What is plugged in there is this process: it gets the
// requests of the kernel's drivers as USB/IP carries them (Documentation/usb/usbip_protocol.rst) and answers them.
// Throws what the kernel refuses.
class VhciPort final : public UsbPort {
 public:
  VhciPort(Speed speed, int number) : UsbPort(speed), number_(number) {}
  ~VhciPort() override { unplug(); }

  void plug() override;
  void unplug();
  bool plugged() const { return socket_ >= 0; }
  // The next request, if one comes within the time. Nothing, too, when the kernel has let go of the device.
  std::optional<Request> wait(int timeout_ms);

  void answer(const Urb& urb, std::span<const std::uint8_t> data) override;
  void answer_packets(const Urb& urb, std::span<const std::vector<std::uint8_t>> packets) override;
  void refuse(const Urb& urb) override;
  void give_back(const Request& request, bool was_waiting) override;

 private:
  bool read_all(void* into, std::size_t bytes);
  void write_all(const void* from, std::size_t bytes);
  void answer_header(const Urb& urb, std::int32_t status, std::uint32_t bytes);

  int number_;
  int socket_ = -1;
};

}  // namespace onemap::test
