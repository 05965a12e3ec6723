#include "kinect.hpp"

#include <sys/time.h>

#include <utility>

#include "hal/base/text.hpp"

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

freenect_frame_mode depth_mode(freenect_depth_format format) {
  for (int i = 0; i < freenect_get_depth_mode_count(); ++i) {
    const freenect_frame_mode mode = freenect_get_depth_mode(i);
    if (mode.is_valid != 0 && mode.depth_format == format && mode.resolution == FREENECT_RESOLUTION_MEDIUM) return mode;
  }
  return {};
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

// What the factory measured is applied by libfreenect where it can; else disparities are turned to depth here.
Status Freenect::configure(std::optional<imaging::Registration> wanted) {
  const freenect_frame_mode registered = depth_mode(FREENECT_DEPTH_REGISTERED);
  const freenect_frame_mode raw = depth_mode(FREENECT_DEPTH_11BIT);
  const bool able = registered.is_valid != 0;
  registration_ = wanted.value_or(able ? imaging::Registration::device : imaging::Registration::ours);
  disparity_ = registration_ != imaging::Registration::device;
  if (!disparity_ && !able)
    return Error{"camera libusb:", "registration=device: libfreenect offers no registered depth"};
  const freenect_frame_mode depth = disparity_ ? raw : registered;
  const freenect_frame_mode colour = freenect_find_video_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_VIDEO_RGB);
  const auto usable = [](const freenect_frame_mode& mode, int bytes_per_pixel) {
    return mode.is_valid != 0 && mode.width == kWidth && mode.height == kHeight &&
           mode.bytes == kWidth * kHeight * bytes_per_pixel;
  };
  if (!usable(depth, 2) || !usable(colour, 3)) return Error{"camera libusb:", "libfreenect offers no 640x480"};
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
