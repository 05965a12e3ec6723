#include "node.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <functional>
#include <utility>

#include "hal/base/text.hpp"

namespace onemap::hal::v4l2 {

namespace {

constexpr std::uint32_t kMostAnswers = 256;  // of an enumeration: a driver that never ends it must not hold us
constexpr std::uint32_t kCapture = V4L2_BUF_TYPE_VIDEO_CAPTURE;

std::string text_of(imaging::ImageSize s) { return fmt::format("{}x{}", s.width, s.height); }

// The kernel's fixed arrays of characters may lack their end.
template <std::size_t N>
std::string text_of(const __u8 (&field)[N]) {
  const char* text = reinterpret_cast<const char*>(field);
  return printable(std::string_view(text, strnlen(text, N)));
}

}  // namespace

int control(int fd, unsigned long request, void* argument) {
  while (ioctl(fd, request, argument) != 0)
    if (errno != EINTR) return errno;
  return 0;
}

Result<Node> Node::open(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    const std::string hint = errno == EACCES ? " (is the user in the group video?)" : "";
    return Error{path, "cannot be opened: " + std::string(std::strerror(errno)) + hint};
  }
  Node node(fd, path);
  v4l2_capability can{};
  if (const int code = control(fd, VIDIOC_QUERYCAP, &can))
    return Error{path, "no V4L2 device: " + std::string(std::strerror(code))};
  const std::uint32_t caps = can.capabilities & V4L2_CAP_DEVICE_CAPS ? can.device_caps : can.capabilities;
  if (!(caps & V4L2_CAP_VIDEO_CAPTURE)) return Error{path, std::string(kNoCapture)};
  if (!(caps & V4L2_CAP_STREAMING)) return Error{path, "cannot stream"};
  node.card_ = text_of(can.card);
  return node;
}

Node::Node(Node&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), path_(std::move(other.path_)), card_(std::move(other.card_)) {}

Node::~Node() {
  if (fd_ >= 0) close(fd_);
}

int Node::release() { return std::exchange(fd_, -1); }

Error Node::error(const std::string& what, int code) const {
  const std::string hint = code == EBUSY ? " (another program uses it)" : "";
  return {path_, what + ": " + std::strerror(code) + hint};
}

std::vector<FourCc> Node::formats() const {
  std::vector<FourCc> formats;
  for (std::uint32_t i = 0; i < kMostAnswers; ++i) {
    v4l2_fmtdesc description{};
    description.index = i;
    description.type = kCapture;
    if (control(fd_, VIDIOC_ENUM_FMT, &description) != 0) break;
    formats.push_back(description.pixelformat);
  }
  return formats;
}

std::string Node::sizes(FourCc format) const {
  std::string text;
  for (std::uint32_t i = 0; i < kMostAnswers; ++i) {
    v4l2_frmsizeenum size{};
    size.index = i;
    size.pixel_format = format;
    if (control(fd_, VIDIOC_ENUM_FRAMESIZES, &size) != 0) break;
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE)
      return fmt::format("{}x{} to {}x{}", size.stepwise.min_width, size.stepwise.min_height, size.stepwise.max_width,
                         size.stepwise.max_height);
    text += fmt::format("{}{}x{}", text.empty() ? "" : " ", size.discrete.width, size.discrete.height);
  }
  return text.empty() ? "sizes unknown" : text;
}

bool Node::has_size(FourCc format, imaging::ImageSize wanted) const {
  const auto width = static_cast<__u32>(wanted.width), height = static_cast<__u32>(wanted.height);
  for (std::uint32_t i = 0; i < kMostAnswers; ++i) {
    v4l2_frmsizeenum size{};
    size.index = i;
    size.pixel_format = format;
    if (control(fd_, VIDIOC_ENUM_FRAMESIZES, &size) != 0) return i == 0;
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) return true;  // any within bounds: S_FMT says it then
    if (size.discrete.width == width && size.discrete.height == height) return true;
  }
  return false;
}

std::vector<int> Node::rates(FourCc format, imaging::ImageSize size) const {
  std::vector<int> rates;
  for (std::uint32_t i = 0; i < kMostAnswers; ++i) {
    v4l2_frmivalenum interval{};
    interval.index = i;
    interval.pixel_format = format;
    interval.width = static_cast<__u32>(size.width);
    interval.height = static_cast<__u32>(size.height);
    if (control(fd_, VIDIOC_ENUM_FRAMEINTERVALS, &interval) != 0) break;
    if (interval.type != V4L2_FRMIVAL_TYPE_DISCRETE) return {};
    const v4l2_fract& one = interval.discrete;
    if (one.numerator != 0 && one.denominator / one.numerator >= 1)
      rates.push_back(static_cast<int>(std::lround(static_cast<double>(one.denominator) / one.numerator)));
  }
  std::ranges::sort(rates, std::greater{});
  return rates;
}

Result<Node::Mode> Node::set_mode(FourCc format, imaging::ImageSize size, int fps) const {
  v4l2_format wanted{};
  wanted.type = kCapture;
  wanted.fmt.pix.width = static_cast<__u32>(size.width);
  wanted.fmt.pix.height = static_cast<__u32>(size.height);
  wanted.fmt.pix.pixelformat = format;
  wanted.fmt.pix.field = V4L2_FIELD_NONE;
  v4l2_format given = wanted;
  if (const int code = control(fd_, VIDIOC_S_FMT, &given)) return error("the mode is refused", code);
  const v4l2_pix_format& pix = given.fmt.pix;
  if (pix.pixelformat != format || pix.width != wanted.fmt.pix.width || pix.height != wanted.fmt.pix.height)
    return Error{path_,
                 fmt::format("asked for {} {}, the driver gives {} {}x{}; it has {}", v4l2::text_of(format),
                             text_of(size), v4l2::text_of(pix.pixelformat), pix.width, pix.height, sizes(format))};
  if (pix.field != V4L2_FIELD_NONE && pix.field != V4L2_FIELD_ANY) return Error{path_, "the images are interlaced"};
  if (const Status status = set_rate(fps); !status) return status.error();
  return Mode{format, size, pix.bytesperline, pix.sizeimage};
}

Status Node::set_rate(int fps) const {
  v4l2_streamparm rate{};
  rate.type = kCapture;
  if (control(fd_, VIDIOC_G_PARM, &rate) != 0) return success();  // a driver without the call has one rate
  if (!(rate.parm.capture.capability & V4L2_CAP_TIMEPERFRAME)) return success();
  rate.parm.capture.timeperframe = {1, static_cast<__u32>(fps)};
  if (const int code = control(fd_, VIDIOC_S_PARM, &rate))
    return error(fmt::format("{} frames a second are refused", fps), code);
  const v4l2_fract given = rate.parm.capture.timeperframe;
  if (given.numerator == 0) return success();
  const double hz = static_cast<double>(given.denominator) / given.numerator;
  if (std::abs(hz - fps) > 0.1 * fps)
    return Error{path_, fmt::format("asked for {} frames a second, the driver gives {:.1f}", fps, hz)};
  return success();
}

}  // namespace onemap::hal::v4l2
