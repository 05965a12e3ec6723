#include "v4l2_camera.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "hal/imaging/raw_depth.hpp"

namespace onemap::hal::v4l2 {

namespace {

using imaging::ImageSize;
using imaging::PairByTime;

// The pipeline may hold five frames that show depth in the driver's buffers, two images wait for a partner, and the
// driver needs a few to go on.
constexpr std::uint32_t kDepthBuffers = 10, kColourBuffers = 5;
constexpr std::uint32_t kLeftForDriver = 3;  // below it depth is copied: a slow reader must not stop the stream
constexpr std::size_t kWaiting = 2;
constexpr int kNap_ms = 1;

// Half a frame interval, and a little for the cameras' uneven pace.
Duration most_apart(int fps) { return Duration(std::chrono::seconds(1)) / (2 * fps) + std::chrono::milliseconds(1); }

}  // namespace

Result<std::unique_ptr<DepthCamera>> V4l2Camera::open(const V4l2Address& address) {
  auto device = find_device(address);
  if (!device) return device.error();
  std::string source;
  auto rig = calibration_of(address, *device, source);
  if (!rig) return rig.error();
  auto timer = Timer::create();
  if (!timer) return timer.error();
  std::unique_ptr<V4l2Camera> camera(
      new V4l2Camera(address, std::move(*device), *rig, std::move(source), std::move(timer).value()));
  if (const Status status = camera->choose_sizes(); !status) return status.error();
  if (const Status status = camera->start(); !status) return status.error();
  return std::unique_ptr<DepthCamera>(std::move(camera));
}

V4l2Camera::V4l2Camera(V4l2Address address, Device device, const imaging::RigCalibration& rig, std::string source,
                       Timer timer)
    : address_(std::move(address)),
      device_(std::move(device)),
      rig_(rig),
      calibration_source_(std::move(source)),
      timer_(std::move(timer)) {}

Status V4l2Camera::choose_sizes() {
  const auto scaled = [&](const Intrinsics& k, const std::optional<ImageSize>& wanted) -> Result<Intrinsics> {
    auto out = imaging::scaled_to(k, wanted.value_or(imaging::size_of(k)));
    return out ? out : Error{calibration_source_, out.error().reason};
  };
  const auto colour = scaled(rig_.colour, address_.size);
  if (!colour) return colour.error();
  colour_ = depth_ = *colour;
  if (address_.as_it_comes && rig_.depth && !imaging::scaled_to(*rig_.depth, imaging::size_of(colour_)))
    return Error{calibration_source_,
                 fmt::format("registration=none is for onemapctl calibrate, which needs depth and colour images of one "
                             "size; this camera's depth, {}x{}, has another shape than its colour, {}x{}: it cannot be "
                             "calibrated so",
                             rig_.depth->width, rig_.depth->height, colour_.width, colour_.height)};
  if (!rig_.depth || address_.as_it_comes) {
    if (address_.depth_size && *address_.depth_size != imaging::size_of(colour_))
      return Error{calibration_source_, "depth that is not registered here has colour's size, not another depth_size"};
    return success();
  }
  const auto depth = scaled(*rig_.depth, address_.depth_size);
  if (!depth) return depth.error();
  depth_ = *depth;
  registration_.emplace(depth_, colour_, rig_.pose, rig_.depth_offset_m);
  plain_depth_.resize(imaging::size_of(depth_).pixels());
  return success();
}

Status V4l2Camera::start() {
  const auto stream = [&](const NodePlace& place, FourCc format, const Intrinsics& k,
                          std::uint32_t buffers) -> Result<std::shared_ptr<Stream>> {
    auto node = Node::open(place.path);
    if (!node) return node.error();
    const auto mode = node->set_mode(format, imaging::size_of(k), address_.fps);
    if (!mode) return mode.error();
    return Stream::start(std::move(node).value(), *mode, buffers);
  };
  auto depth = stream(device_.depth, device_.depth_format, depth_, kDepthBuffers);
  if (!depth) return depth.error();
  auto colour = stream(device_.colour, device_.colour_format, colour_, kColourBuffers);
  if (!colour) return colour.error();
  depth_stream_ = std::move(*depth);
  colour_stream_ = std::move(*colour);
  depth_images_.assign(Stream::kMost, {});
  colour_images_.assign(Stream::kMost, {});
  pairs_.emplace(most_apart(address_.fps), kWaiting);
  return success();
}

Grab V4l2Camera::lose(Error why) {
  depth_stream_.reset();  // frames that still show its memory keep it mapped
  colour_stream_.reset();
  last_error_ = std::move(why);
  return Grab::gone;
}

// No driver said that anything is wrong: the device was reset, or it hangs.
Grab V4l2Camera::stalled() {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(Stall::kAfter).count();
  const bool listed = find_again(device_).ok();
  return lose({device_.depth.path, fmt::format("gave nothing for {} s{}", seconds,
                                               listed ? " though it is still connected; it is opened again"
                                                      : ", and is not there any more")});
}

bool V4l2Camera::come_back() {
  auto device = find_again(device_);
  Status status = device ? success() : Status(device.error());
  if (status) {
    device_ = std::move(*device);
    status = start();
  }
  if (!status) lose(status.error());
  return status.ok();
}

Grab V4l2Camera::grab(Frame& into, std::chrono::milliseconds timeout) {
  into.return_loan();
  timer_.start(timeout);
  if (!depth_stream_ && !come_back()) {
    wait(false);
    return Grab::gone;
  }
  for (Woken woken = Woken::time;; woken = wait(true)) {
    bool nothing = true;
    while (true) {
      if (const auto grabbed = settle(into)) return *grabbed;
      const Looked looked = look_at_both();
      if (looked == Looked::gone) return Grab::gone;
      if (looked == Looked::nothing) break;
      nothing = false;
    }
    if (timer_.over()) return stall_.waited(timeout) ? stalled() : Grab::timeout;
    if (nothing && woken == Woken::trouble) return lose(depth_stream_->lost("poll reports an error"));
    if (nothing && woken == Woken::image) poll(nullptr, 0, kNap_ms);  // said to be ready, and is not: not at full speed
  }
}

V4l2Camera::Looked V4l2Camera::look_at_both() {
  for (Stream* stream : {depth_stream_.get(), colour_stream_.get()}) {
    const Looked one = look(*stream, stream == colour_stream_.get());
    if (one == Looked::gone) {
      lose(stream->error());
      return Looked::gone;
    }
    if (one == Looked::something) return one;  // settled before the next, as pairing wants it
  }
  return Looked::nothing;
}

// Until an image may be there or the time is over. A device that is away has nothing to wait for but the time.
V4l2Camera::Woken V4l2Camera::wait(bool streaming) {
  pollfd files[3] = {{timer_.fd(), POLLIN, 0}, {-1, POLLIN, 0}, {-1, POLLIN, 0}};
  if (streaming) {
    files[1].fd = depth_stream_->fd();
    files[2].fd = colour_stream_->fd();
  }
  poll(files, 3, -1);
  const int seen = files[1].revents | files[2].revents;
  if (seen & (POLLERR | POLLHUP | POLLNVAL)) return Woken::trouble;
  return seen != 0 ? Woken::image : Woken::time;
}

V4l2Camera::Looked V4l2Camera::look(Stream& stream, bool colour) {
  Stream::Image image;
  switch (stream.take(image)) {
    case Stream::Taken::nothing:
      return Looked::nothing;
    case Stream::Taken::gone:
      return Looked::gone;
    case Stream::Taken::image:
      break;
  }
  if (!colour) counters_.missed += image.missed;
  const PairByTime::Image timed{FrameTime(image.stamp + address_.clock_offset), image.buffer};
  (colour ? colour_images_ : depth_images_)[image.buffer] = std::move(image);
  if (!(colour ? pairs_->add_colour(timed) : pairs_->add_depth(timed))) {
    ++counters_.bad;  // a stamp that does not increase: nothing can be its partner
    last_error_ = stream.lost("an image's time does not come after the last one's");
    stream.give_back(timed.buffer);
  }
  return Looked::something;
}

std::optional<Grab> V4l2Camera::settle(Frame& into) {
  while (true) {
    const PairByTime::Outcome outcome = pairs_->next();
    switch (outcome.kind) {
      case PairByTime::Kind::nothing:
        return std::nullopt;
      case PairByTime::Kind::pair:
        return deliver(outcome, into);
      case PairByTime::Kind::lone_colour:
        colour_stream_->give_back(outcome.colour.buffer);
        break;
      case PairByTime::Kind::lone_depth:
        depth_stream_->give_back(outcome.depth.buffer);
        break;
    }
    ++counters_.unmatched;
  }
}

Grab V4l2Camera::deliver(const PairByTime::Outcome& pair, Frame& into) {
  const Stream::Image& colour = colour_images_[pair.colour.buffer];
  bool lent = false;
  Status status =
      colour.damage.empty()
          ? decode_colour(device_.colour_format,
                          {colour.bytes, imaging::size_of(colour_), colour_stream_->mode().stride_bytes}, into.rgb())
          : Status(Error{"", colour.damage});
  std::string place = colour_stream_->path();
  if (status) {
    status = fill_depth(pair.depth.buffer, into, lent);
    place = depth_stream_->path();
  }
  colour_stream_->give_back(pair.colour.buffer);
  if (!lent) depth_stream_->give_back(pair.depth.buffer);
  stall_.came();
  if (!status) {
    ++counters_.bad;
    last_error_ = {place, status.error().reason};
    return Grab::bad;
  }
  into.colour_time = pair.colour.time;
  into.depth_time = pair.depth.time;
  into.index = next_index_++;
  ++counters_.frames;
  return Grab::frame;
}

Status V4l2Camera::fill_depth(std::uint32_t buffer, Frame& into, bool& lent) {
  const Stream::Image& image = depth_images_[buffer];
  if (!image.damage.empty()) return Error{"", image.damage};
  const imaging::RawImage raw{image.bytes, imaging::size_of(depth_), depth_stream_->mode().stride_bytes};
  const std::size_t row_bytes = 2 * static_cast<std::size_t>(depth_.width);
  if (Status status = imaging::check_rows(raw, row_bytes); !status) return status;
  const bool as_it_is = raw.stride(row_bytes) == row_bytes && rig_.depth_none == 0;
  const std::span<const std::uint16_t> values(reinterpret_cast<const std::uint16_t*>(image.bytes.data()),
                                              raw.size.pixels());
  lent = as_it_is && !registration_ && depth_stream_->with_driver() >= kLeftForDriver;
  if (lent) {
    into.borrow({values, depth_stream_,
                 [](void* stream, std::uint32_t which) { static_cast<Stream*>(stream)->give_back(which); }, buffer});
    return success();
  }
  if (as_it_is && registration_) {
    registration_->apply(values, into.depth());
    return success();
  }
  const std::span<std::uint16_t> copy = registration_ ? std::span(plain_depth_) : into.depth();
  if (Status status = imaging::z16_to_depth(raw, copy); !status) return status;
  if (rig_.depth_none != 0) imaging::clear_value(rig_.depth_none, copy);
  if (registration_) registration_->apply(copy, into.depth());
  return success();
}

std::string V4l2Camera::description() const {
  const std::string name = device_.depth.product.empty() ? device_.depth.name : device_.depth.product;
  return fmt::format("{}{}{}, depth {} {} {}x{}, colour {} {} {}x{}, {} frames a second, calibration: {}", name,
                     device_.depth.serial.empty() ? "" : " ", device_.depth.serial, device_.depth.path,
                     text_of(device_.depth_format), depth_.width, depth_.height, device_.colour.path,
                     text_of(device_.colour_format), colour_.width, colour_.height, address_.fps, calibration_source_);
}

}  // namespace onemap::hal::v4l2
