#include "mock_node.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace onemap::test {

namespace {

void init_class(gpointer klass, gpointer) {
  static_cast<UMockdevIoctlBaseClass*>(klass)->handle_ioctl = MockNode::on_ioctl;
}

GType handler_type() {
  static const GType type =
      g_type_register_static_simple(umockdev_ioctl_base_get_type(), "OnemapMockUvcNode", sizeof(UMockdevIoctlBaseClass),
                                    init_class, sizeof(UMockdevIoctlBase), nullptr, GTypeFlags{});
  return type;
}

}  // namespace

MockNode::MockNode(MockUvc& device, MockNodeConfig config) : device_(device), config_(std::move(config)) {
  mode_ = {config_.formats.front(), config_.sizes.front().first, config_.sizes.front().second};
}

void MockNode::attach(const std::string& path, const std::string& file) {
  path_ = path;
  file_ = file;
  // umockdev makes a pty; a plain file in its place can be mapped, and calls still come to the handler by the path.
  unlink(file.c_str());
  const int fd = ::open(file.c_str(), O_CREAT | O_RDWR, 0600);
  if (fd < 0) throw std::runtime_error("no file for " + path);
  close(fd);
  handler_ = static_cast<UMockdevIoctlBase*>(g_object_new(handler_type(), nullptr));
  g_object_set_data(reinterpret_cast<GObject*>(handler_), "node", this);
  if (!umockdev_testbed_attach_ioctl(device_.testbed_.handle(), path.c_str(), handler_, nullptr))
    throw std::runtime_error("umockdev does not take the handler of " + path);
}

void MockNode::detach() {
  if (!handler_) return;
  umockdev_testbed_detach_ioctl(device_.testbed_.handle(), path_.c_str(), nullptr);
  g_object_unref(handler_);
  handler_ = nullptr;
  forget();
}

void MockNode::forget() {
  if (memory_) munmap(memory_, memory_bytes_);
  memory_ = nullptr;
  queued_.clear();
  done_.clear();
  streaming_ = false;
  buffers_ = 0;
}

bool MockNode::wants(std::uint32_t format, std::uint32_t width, std::uint32_t height) const {
  const bool known = std::ranges::find(config_.formats, format) != config_.formats.end();
  return known && std::ranges::find(config_.sizes, std::pair(width, height)) != config_.sizes.end();
}

// As drivers do: what it cannot do becomes what it can, without a word.
int MockNode::set_format(v4l2_format& f) {
  auto& pix = f.fmt.pix;
  if (wants(pix.pixelformat, pix.width, pix.height)) {
    mode_ = {pix.pixelformat, pix.width, pix.height};
  } else {
    mode_ = {config_.formats.front(), config_.sizes.front().first, config_.sizes.front().second};
  }
  pix.pixelformat = mode_.format;
  pix.width = mode_.width;
  pix.height = mode_.height;
  pix.bytesperline = stride();
  pix.sizeimage = image_bytes();
  pix.field = V4L2_FIELD_NONE;
  return 0;
}

int MockNode::enumerate_sizes(v4l2_frmsizeenum& s) const {
  if (s.index >= config_.sizes.size()) return EINVAL;
  s.type = V4L2_FRMSIZE_TYPE_DISCRETE;
  s.discrete.width = config_.sizes[s.index].first;
  s.discrete.height = config_.sizes[s.index].second;
  return 0;
}

int MockNode::enumerate_rates(v4l2_frmivalenum& v) const {
  if (config_.rates.empty()) return ENOTTY;
  if (!wants(v.pixel_format, v.width, v.height) || v.index >= config_.rates.size()) return EINVAL;
  v.type = V4L2_FRMIVAL_TYPE_DISCRETE;
  v.discrete = {1, config_.rates[v.index]};
  return 0;
}

int MockNode::request_buffers(v4l2_requestbuffers& r) {
  forget();
  r.count = buffers_ = std::min(r.count, config_.most_buffers);
  if (r.count == 0) return 0;
  memory_bytes_ = std::size_t{slot_bytes()} * buffers_;
  const int fd = ::open(file_.c_str(), O_RDWR);
  const bool grown = fd >= 0 && ftruncate(fd, static_cast<off_t>(memory_bytes_)) == 0;
  void* memory = grown ? mmap(nullptr, memory_bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0) : MAP_FAILED;
  if (fd >= 0) close(fd);
  if (memory == MAP_FAILED) return ENOMEM;
  memory_ = static_cast<std::uint8_t*>(memory);
  return 0;
}

// All images that are due by now: into the oldest buffer that waits, or lost.
void MockNode::produce() {
  while (streaming_ && !hangs && !device_.paused_ && next_us_ <= device_.now_us_) {
    if (!queued_.empty()) {
      const std::uint32_t index = queued_.front();
      queued_.pop_front();
      config_.content(mode_, sequence_, memory_ + std::size_t{index} * slot_bytes(), stride());
      std::uint32_t flags = V4L2_BUF_FLAG_DONE | config_.clock;
      if (std::exchange(damage_next, false)) flags |= V4L2_BUF_FLAG_ERROR;
      done_.push_back({index, sequence_, flags, next_us_});
    }
    ++sequence_;
    next_us_ += 1'000'000 / fps_;
  }
  if (device_.paused_) next_us_ = std::max(next_us_, device_.now_us_);
}

int MockNode::take(v4l2_buffer& b) {
  produce();
  if (done_.empty()) {
    device_.now_us_ += 500;
    return EAGAIN;
  }
  const Done done = done_.front();
  done_.pop_front();
  b.index = done.index;
  b.sequence = done.sequence;
  b.flags = done.flags;
  b.bytesused = image_bytes();
  b.field = V4L2_FIELD_NONE;
  b.timestamp.tv_sec = done.time_us / 1'000'000;
  b.timestamp.tv_usec = done.time_us % 1'000'000;
  return 0;
}

int MockNode::call(unsigned long request, std::uint8_t* argument) {
  if (device_.until_vanished_ >= 0 && device_.until_vanished_-- == 0) device_.present_ = false;
  if (!device_.present_) return ENODEV;
  if (refused_request == request) {
    if (!refuses_always) refused_request = 0;
    return refused_code;
  }
  const int code = choose(request, argument);
  return code == ENOTTY ? stream(request, argument) : code;
}

int MockNode::describe(v4l2_capability& v) const {
  std::memset(&v, 0, sizeof v);
  std::strncpy(reinterpret_cast<char*>(v.driver), "uvcvideo", sizeof v.driver - 1);
  std::strncpy(reinterpret_cast<char*>(v.card), "Mock depth camera", sizeof v.card - 1);
  v.device_caps = (config_.captures ? V4L2_CAP_VIDEO_CAPTURE : V4L2_CAP_META_CAPTURE) | V4L2_CAP_STREAMING;
  v.capabilities = v.device_caps | V4L2_CAP_DEVICE_CAPS;
  return 0;
}

int MockNode::enumerate_formats(v4l2_fmtdesc& v) const {
  if (v.index >= config_.formats.size()) return EINVAL;
  v.pixelformat = config_.formats[v.index];
  return 0;
}

int MockNode::set_rate(v4l2_streamparm& v, bool wanted) {
  auto& capture = v.parm.capture;
  capture.capability = V4L2_CAP_TIMEPERFRAME;
  if (wanted && !config_.fixed_rate && capture.timeperframe.numerator == 1)
    fps_ = static_cast<int>(capture.timeperframe.denominator);
  if (config_.fixed_rate) fps_ = config_.fps;
  capture.timeperframe = {1, static_cast<__u32>(fps_)};
  return 0;
}

// What there is, and what of it is wanted; ENOTTY: another call.
int MockNode::choose(unsigned long request, std::uint8_t* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP:
      return describe(*reinterpret_cast<v4l2_capability*>(argument));
    case VIDIOC_ENUM_FMT:
      return enumerate_formats(*reinterpret_cast<v4l2_fmtdesc*>(argument));
    case VIDIOC_ENUM_FRAMESIZES:
      return enumerate_sizes(*reinterpret_cast<v4l2_frmsizeenum*>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return enumerate_rates(*reinterpret_cast<v4l2_frmivalenum*>(argument));
    case VIDIOC_S_FMT:
      return streaming_ ? EBUSY : set_format(*reinterpret_cast<v4l2_format*>(argument));
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM:
      return set_rate(*reinterpret_cast<v4l2_streamparm*>(argument), request == VIDIOC_S_PARM);
    default:
      return ENOTTY;
  }
}

int MockNode::stream(unsigned long request, std::uint8_t* argument) {
  switch (request) {
    case VIDIOC_REQBUFS:
      return streaming_ ? EBUSY : request_buffers(*reinterpret_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      return describe(*reinterpret_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      return queue(reinterpret_cast<v4l2_buffer*>(argument)->index);
    case VIDIOC_DQBUF:
      return take(*reinterpret_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      streaming_ = true;
      hangs = false;
      sequence_ = 0;
      next_us_ = device_.now_us_ + 1'000'000 / fps_ + config_.phase_us;
      return 0;
    case VIDIOC_STREAMOFF:
      forget();
      return 0;
    default:
      return ENOTTY;
  }
}

int MockNode::describe(v4l2_buffer& v) const {
  if (v.index >= buffers_) return EINVAL;
  v.length = slot_bytes();
  v.m.offset = v.index * slot_bytes();
  return 0;
}

int MockNode::queue(std::uint32_t index) {
  if (index >= buffers_ || std::ranges::find(queued_, index) != queued_.end()) return EINVAL;
  queued_.push_back(index);
  return 0;
}

gboolean MockNode::on_ioctl(UMockdevIoctlBase* base, UMockdevIoctlClient* client) {
  auto* node = static_cast<MockNode*>(g_object_get_data(reinterpret_cast<GObject*>(base), "node"));
  const unsigned long request = umockdev_ioctl_client_get_request(client) & 0xFFFFFFFFu;
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  UMockdevIoctlData* data = umockdev_ioctl_data_resolve(argument, 0, _IOC_SIZE(request), nullptr);
  if (!data) return FALSE;
  std::vector<std::uint8_t> bytes(data->data, data->data + data->data_len);
  int code = 0;
  {
    const std::lock_guard lock(node->device_.mutex_);
    code = node->call(request, bytes.data());
  }
  if (code == 0) umockdev_ioctl_data_update(data, 0, bytes.data(), static_cast<gint>(bytes.size()));
  umockdev_ioctl_data_unref(data);
  umockdev_ioctl_client_complete(client, code == 0 ? 0 : -1, code);
  return TRUE;
}

}  // namespace onemap::test
