#pragma once
#include "film.hpp"
#include "usb_device.hpp"

namespace onemap::test {

// A depth camera of USB's video class, as RealSense's are: two functions, depth as Z16 and colour as YUYV, each a bulk
// stream at 30 Hz in the size of the film.
class UvcDevice final : public UsbDevice {
 public:
  UvcDevice(const Film& film, Projector& projector) : film_(film), projector_(projector) {}
  static Film::Picture develop(const hal::FrameView& frame);  // what a film for it holds

  void step(Moment now, UsbPort& port) override;
  Moment next_step() const override { return projector_.next(); }

 private:
  struct Stream {
    int endpoint = 0;
    bool wanted = false;
    std::uint8_t frame_id = 0;
    Bytes image{};  // what is being sent
    std::size_t sent = 0;
  };
  Bytes device_descriptor(UsbPort::Speed speed) const override;
  Bytes configuration(UsbPort::Speed speed) const override;
  std::string text(int index) const override;
  std::optional<Bytes> control(const Setup& setup, std::span<const std::uint8_t> out) override;
  void forget() override;
  void stopped(int endpoint) override;
  void load(Stream& stream, const Bytes& image);
  void send(Stream& stream, UsbPort& port);

  std::uint32_t image_bytes() const { return 2 * film_.width() * film_.height(); }

  const Film& film_;
  Projector& projector_;
  Stream depth_{.endpoint = 1}, colour_{.endpoint = 2};
};

}  // namespace onemap::test
