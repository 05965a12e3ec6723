#pragma once
#include <libfreenect.h>

#include <atomic>
#include <memory>
#include <optional>
#include <thread>

#include "address.hpp"
#include "hal/base/result.hpp"
#include "hal/imaging/image_size.hpp"
#include "hal/imaging/tabled_registration.hpp"
#include "image_ring.hpp"
#include "usb.hpp"

namespace onemap::hal::libusb {

constexpr imaging::ImageSize kSize{640, 480};

// How images come. libfreenect would turn the device's own bytes into pixels on the thread of its events, slowly; so
// they are asked for as they are, which fakenect, its stand-in, does not have.
struct Forms {
  bool packed = false;  // disparities of 11 bits without gaps, else each in 16
  bool mosaic = false;  // Bayer's, else RGB
};

// libfreenect on our libusb context. Its calls are not safe beside each other, so the thread that handles the events
// stands still while a device is opened or closed.
class Freenect {
 public:
  static Result<std::unique_ptr<Freenect>> start(Usb& usb);
  ~Freenect();
  Freenect(const Freenect&) = delete;
  Freenect& operator=(const Freenect&) = delete;

  // Opens the Kinect with this number on the bus (Usb::kinects) and starts both streams into a new ring.
  Status open(int index, std::optional<imaging::Registration> wanted);
  void close();
  bool is_open() const { return device_ != nullptr; }
  // The bus or libfreenect says that the device is not there any more.
  bool lost() const { return failed_ || usb_.left(); }

  int devices();  // that libfreenect sees
  ImageRing& images() { return *images_; }
  imaging::Registration registration() const { return registration_; }
  Forms forms() const { return forms_; }
  imaging::TabledRegistration* factory() { return factory_.get(); }  // what registers where the device does; else null

 private:
  explicit Freenect(Usb& usb) : usb_(usb) {}
  Status configure(std::optional<imaging::Registration> wanted);
  Status choose_modes();
  Status start_streams();
  void close_device();
  void start_events();
  void stop_events();

  Usb& usb_;
  freenect_context* context_ = nullptr;
  freenect_device* device_ = nullptr;
  std::unique_ptr<ImageRing> images_;
  imaging::Registration registration_ = imaging::Registration::none;
  Forms forms_;
  std::unique_ptr<imaging::TabledRegistration> factory_;
  std::atomic<bool> stopping_ = false, failed_ = false;
  std::thread events_;
};

}  // namespace onemap::hal::libusb
