#include "stream.hpp"

#include <linux/videodev2.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace onemap::hal::v4l2 {

namespace {

v4l2_buffer described(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

std::string reason(const char* what, int code) {
  const char* hint = code == EBUSY    ? " (another program uses it)"
                     : code == ENOSPC ? " (the USB bus has no room: another port, a smaller size or a lower frame rate)"
                                      : "";
  return std::string(what) + ": " + std::strerror(code) + hint;
}

// The stamp of a buffer is of the monotonic clock, or made by who feeds a loopback device.
bool usable_clock(std::uint32_t flags) {
  const std::uint32_t clock = flags & V4L2_BUF_FLAG_TIMESTAMP_MASK;
  return clock == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC || clock == V4L2_BUF_FLAG_TIMESTAMP_COPY;
}

}  // namespace

Result<std::shared_ptr<Stream>> Stream::start(Node node, const Node::Mode& mode, std::uint32_t buffers) {
  const std::string path = node.path();
  const std::shared_ptr<Stream> stream(new Stream(node.release(), path, mode));
  if (const Status status = stream->map(buffers); !status) return status.error();
  if (const Status status = stream->run(); !status) return status.error();
  return stream;
}

Status Stream::map(std::uint32_t wanted) {
  v4l2_requestbuffers request{};
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  request.count = wanted;
  if (const int code = control(fd_, VIDIOC_REQBUFS, &request)) return Error{path_, reason("no buffers", code)};
  if (request.count < kFewest || request.count > kMost)
    return Error{path_, "the driver gives " + std::to_string(request.count) + " buffers"};
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = described(i);
    if (const int code = control(fd_, VIDIOC_QUERYBUF, &buffer))
      return Error{path_, reason("a buffer is unknown", code)};
    void* memory = mmap(nullptr, buffer.length, PROT_READ, MAP_SHARED, fd_, buffer.m.offset);
    if (memory == MAP_FAILED) return Error{path_, reason("a buffer cannot be mapped", errno)};
    mappings_.push_back({memory, buffer.length});
  }
  return success();
}

Status Stream::run() {
  for (std::uint32_t i = 0; i < mappings_.size(); ++i) {
    v4l2_buffer buffer = described(i);
    if (const int code = control(fd_, VIDIOC_QBUF, &buffer)) return Error{path_, reason("a buffer is refused", code)};
    ++with_driver_;
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int code = control(fd_, VIDIOC_STREAMON, &type)) return Error{path_, reason("it does not stream", code)};
  running_ = true;
  return success();
}

Stream::~Stream() {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (running_) control(fd_, VIDIOC_STREAMOFF, &type);
  for (const Mapping& mapping : mappings_) munmap(mapping.memory, mapping.bytes);
  close(fd_);
}

Stream::Taken Stream::take(Image& into) {
  v4l2_buffer buffer = described(0);
  if (const int code = control(fd_, VIDIOC_DQBUF, &buffer)) {
    if (code == EAGAIN) return Taken::nothing;
    error_ = {path_, reason("the stream broke", code)};
    return Taken::gone;
  }
  if (buffer.index >= mappings_.size()) {
    error_ = {path_, "the driver names a buffer that there is not"};
    return Taken::gone;
  }
  --with_driver_;
  const Mapping& mapping = mappings_[buffer.index];
  into = {};
  into.buffer = buffer.index;
  into.bytes = {static_cast<const std::uint8_t*>(mapping.memory),
                std::min<std::size_t>(buffer.bytesused, mapping.bytes)};
  into.stamp = std::chrono::seconds(buffer.timestamp.tv_sec) + std::chrono::microseconds(buffer.timestamp.tv_usec);
  if (buffer.flags & V4L2_BUF_FLAG_ERROR) into.damage = "the driver marks the image as damaged";
  if (!usable_clock(buffer.flags)) into.damage = "the driver does not say which clock its stamps are of";
  if (any_ && buffer.sequence > last_sequence_) into.missed = buffer.sequence - last_sequence_ - 1;
  any_ = true;
  last_sequence_ = buffer.sequence;
  return Taken::image;
}

void Stream::give_back(std::uint32_t index) {
  v4l2_buffer buffer = described(index);
  // A device that is gone takes nothing back; the next take() says so.
  if (control(fd_, VIDIOC_QBUF, &buffer) == 0) ++with_driver_;
}

}  // namespace onemap::hal::v4l2
