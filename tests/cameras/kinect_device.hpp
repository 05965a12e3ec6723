#pragma once
#include "film.hpp"
#include "usb_device.hpp"

namespace onemap::test {

// The camera of a Kinect v1 (model 1414): isochronous streams of packed disparities and of a Bayer mosaic, what the
// factory measured, and the registers that start and stop them, as libfreenect 0.5.3 expects them. Depth is seen by a
// lens of its own, which is where the factory's numbers put it, so that libfreenect's registration has work to do.
class KinectDevice final : public UsbDevice {
 public:
  KinectDevice(const Film& film, Projector& projector, std::string serial = "A00VM00000000001");
  static Film::Picture develop(const hal::FrameView& frame);  // what a film for it holds; 640x480

  void step(Moment now, UsbPort& port) override;
  Moment next_step() const override;

 private:
  struct Stream {
    int endpoint = 0;
    std::uint8_t flag = 0;
    std::size_t packet_bytes = 0;  // without the header
    bool wanted = false;
    std::uint8_t sequence = 0;
    Bytes image{};
    std::size_t sent = 0;
    std::size_t packets() const { return (image.size() + packet_bytes - 1) / packet_bytes; }
    std::size_t packets_sent() const { return (sent + packet_bytes - 1) / packet_bytes; }
  };
  Bytes device_descriptor(UsbPort::Speed speed) const override;
  Bytes configuration(UsbPort::Speed speed) const override;
  std::string text(int index) const override;
  std::optional<Bytes> control(const Setup& setup, std::span<const std::uint8_t> out) override;
  void forget() override;
  void stopped(int endpoint) override;
  void command(std::span<const std::uint8_t> out);
  Bytes parameters(unsigned which) const;
  void write_register(unsigned number, unsigned value);
  void load(Stream& stream, const Bytes& image);
  void send(Stream& stream, Moment now, UsbPort& port);
  Bytes packet(Stream& stream) const;

  const Film& film_;
  Projector& projector_;
  const std::string serial_;
  Stream colour_{.endpoint = 1, .flag = 0x80, .packet_bytes = 1920 - 12};
  Stream depth_{.endpoint = 2, .flag = 0x70, .packet_bytes = 1760 - 12};
  Bytes reply_;
  std::uint32_t ticks_ = 0;
};

}  // namespace onemap::test
