#include "kinect.hpp"

#include <libfreenect_registration.h>
#include <sys/time.h>

#include <utility>

#include "hal/base/text.hpp"

// Null where a libfreenect without them is loaded.
#pragma weak freenect_copy_registration
#pragma weak freenect_destroy_registration

namespace onemap::hal::libusb {

namespace {

// libfreenect tells why through its log alone, on the thread that called it.
thread_local std::string last_message;

void keep_message(freenect_context*, freenect_loglevel level, const char* message) {
  if (level <= FREENECT_LOG_ERROR) last_message = message;
}

Error freenect_error(const std::string& what) {
  std::string why = std::exchange(last_message, {});
  while (!why.empty() && why.back() == '\n') why.pop_back();
  return {"camera libusb:", printable(why.empty() ? what : what + ": " + why)};
}

bool is_usable(const freenect_frame_mode& mode, int bytes) {
  return mode.is_valid != 0 && mode.width == kSize.width && mode.height == kSize.height && mode.bytes == bytes;
}

// What is not there is nobody's business: its stand-in complains of what it is asked for and lacks.
freenect_frame_mode depth_mode(freenect_depth_format format, int bytes) {
  for (int i = 0; i < freenect_get_depth_mode_count(); ++i) {
    const freenect_frame_mode mode = freenect_get_depth_mode(i);
    if (mode.depth_format == format && mode.resolution == FREENECT_RESOLUTION_MEDIUM && is_usable(mode, bytes))
      return mode;
  }
  return {};
}

freenect_frame_mode colour_mode(freenect_video_format format, int bytes) {
  for (int i = 0; i < freenect_get_video_mode_count(); ++i) {
    const freenect_frame_mode mode = freenect_get_video_mode(i);
    if (mode.video_format == format && mode.resolution == FREENECT_RESOLUTION_MEDIUM && is_usable(mode, bytes))
      return mode;
  }
  return {};
}

// The device's own numbers, as tables. libfreenect's stand-in has no such function.
std::unique_ptr<imaging::TabledRegistration> factory_registration(freenect_device* device) {
  if (freenect_copy_registration == nullptr) return nullptr;
  freenect_registration measured = freenect_copy_registration(device);
  const imaging::FactoryTables tables{
      {measured.raw_to_mm_shift, FREENECT_DEPTH_RAW_MAX_VALUE},
      {measured.depth_to_rgb_shift, FREENECT_DEPTH_MM_MAX_VALUE},
      {measured.registration_table[0], 2 * kSize.pixels()},
      kSize.height * measured.reg_pad_info.start_lines,
  };
  auto registration = std::make_unique<imaging::TabledRegistration>(kSize, tables);
  freenect_destroy_registration(&measured);
  return registration;
}

}  // namespace

Result<std::unique_ptr<Freenect>> Freenect::start(Usb& usb) {
  std::unique_ptr<Freenect> self(new Freenect(usb));
  if (freenect_init(&self->context_, usb.context()) != 0) return freenect_error("libfreenect cannot start");
  freenect_set_log_callback(self->context_, keep_message);
  freenect_set_log_level(self->context_, FREENECT_LOG_ERROR);
  freenect_select_subdevices(self->context_, FREENECT_DEVICE_CAMERA);  // not the motor, and so not tilt and LED
  return self;
}

Freenect::~Freenect() {
  close_device();
  if (context_) freenect_shutdown(context_);
}

int Freenect::devices() { return freenect_num_devices(context_); }

void Freenect::start_events() {
  stopping_ = false;
  failed_ = false;
  events_ = std::thread([this] {
    while (!stopping_) {
      timeval wait{0, 50'000};
      if (freenect_process_events_timeout(context_, &wait) >= 0) continue;
      failed_ = true;
      break;
    }
    if (images_) images_->close();
  });
}

void Freenect::stop_events() {
  stopping_ = true;
  if (events_.joinable()) events_.join();
}

Status Freenect::open(int index, std::optional<imaging::Registration> wanted) {
  stop_events();
  const auto give_up = [this](Error error) -> Status {
    close();
    return error;
  };
  if (freenect_open_device(context_, &device_, index) != 0) {
    device_ = nullptr;
    start_events();
    return freenect_error("cannot be opened");
  }
  if (const Status status = configure(wanted); !status) return give_up(status.error());
  if (const Status status = start_streams(); !status) return give_up(status.error());
  start_events();
  return success();
}

Status Freenect::configure(std::optional<imaging::Registration> wanted) {
  if (Status status = choose_modes(); !status) return status;
  const bool all_of_it = wanted.value_or(imaging::Registration::device) == imaging::Registration::device;
  factory_ = all_of_it && forms_.packed ? factory_registration(device_) : nullptr;
  registration_ = wanted.value_or(factory_ ? imaging::Registration::device : imaging::Registration::ours);
  if (registration_ == imaging::Registration::device && !factory_)
    return Error{"camera libusb:", "registration=device: libfreenect offers no registered depth"};
  return success();
}

// Colour's mode last: with it libfreenect asks the device for what the factory measured.
Status Freenect::choose_modes() {
  constexpr int kPixels = kSize.width * kSize.height;
  freenect_frame_mode depth = depth_mode(FREENECT_DEPTH_11BIT_PACKED, kPixels / 8 * 11);
  freenect_frame_mode colour = colour_mode(FREENECT_VIDEO_BAYER, kPixels);
  forms_ = {depth.is_valid != 0, colour.is_valid != 0};
  if (!forms_.packed) depth = depth_mode(FREENECT_DEPTH_11BIT, 2 * kPixels);
  if (!forms_.mosaic) colour = colour_mode(FREENECT_VIDEO_RGB, 3 * kPixels);
  if (depth.is_valid == 0 || colour.is_valid == 0) return Error{"camera libusb:", "libfreenect offers no 640x480"};
  if (freenect_set_depth_mode(device_, depth) != 0) return freenect_error("does not take its depth mode");
  if (freenect_set_video_mode(device_, colour) != 0) return freenect_error("does not take its colour mode");
  images_ = std::make_unique<ImageRing>(static_cast<std::size_t>(depth.bytes), static_cast<std::size_t>(colour.bytes));
  return success();
}

Status Freenect::start_streams() {
  freenect_set_user(device_, images_.get());
  freenect_set_depth_callback(device_, [](freenect_device* device, void*, std::uint32_t ticks) {
    auto* images = static_cast<ImageRing*>(freenect_get_user(device));
    freenect_set_depth_buffer(device, images->filled(Stream::depth, ticks));
  });
  freenect_set_video_callback(device_, [](freenect_device* device, void*, std::uint32_t ticks) {
    auto* images = static_cast<ImageRing*>(freenect_get_user(device));
    freenect_set_video_buffer(device, images->filled(Stream::colour, ticks));
  });
  if (freenect_set_depth_buffer(device_, images_->first_slot(Stream::depth)) != 0 ||
      freenect_set_video_buffer(device_, images_->first_slot(Stream::colour)) != 0)
    return freenect_error("does not take our buffers");
  if (freenect_start_depth(device_) != 0) return freenect_error("depth does not start");
  if (freenect_start_video(device_) != 0) return freenect_error("colour does not start");
  return success();
}

void Freenect::close() {
  close_device();
  start_events();  // they tell when a device comes
}

void Freenect::close_device() {
  stop_events();
  if (device_) {
    freenect_stop_depth(device_);
    freenect_stop_video(device_);
    freenect_close_device(device_);
    device_ = nullptr;
  }
  images_.reset();
}

}  // namespace onemap::hal::libusb
