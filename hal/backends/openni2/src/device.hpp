#pragma once
#include <OpenNI.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "address.hpp"
#include "hal/backends/openni2/modes.hpp"
#include "hal/base/result.hpp"
#include "hal/frame.hpp"

namespace onemap::hal::openni2 {

// What tells one physical device from another across a re-plug: its URI holds the USB address, which changes.
struct Identity {
  std::string uri, name, serial;  // serial may be empty
  int vendor = 0, product = 0;    // USB
  bool may_be(const Identity& other) const;
};
Identity identity_of(const openni::DeviceInfo& info);

// A device or a recording, open, with depth and colour running in the modes that were chosen.
class Device {
 public:
  static Result<std::unique_ptr<Device>> open(const Address& address, const std::string& uri);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  enum class Image { depth, colour, none, broken };
  // The next image of either stream into `into`. None: nothing within the time. Broken: last_error().
  Image read(openni::VideoFrameRef& into, std::chrono::milliseconds timeout);
  const Error& last_error() const { return error_; }

  const Identity& identity() const { return identity_; }
  const ModePair& modes() const { return modes_; }
  imaging::Registration registration() const { return registration_; }
  bool depth_mirrored() const { return depth_mirrored_; }
  bool colour_mirrored() const { return colour_mirrored_; }
  // Of the colour image, and of the depth image where depth is not registered: pinholes by the fields of view.
  const Intrinsics& colour() const { return colour_; }
  const Intrinsics& depth() const { return depth_; }
  bool colour_is_nominal() const { return colour_is_nominal_; }
  // Of a recording, the fewer of the two streams; 0 of a device.
  std::uint64_t recorded_frames() const { return std::min(recorded_[0], recorded_[1]); }
  bool played_to_the_end() const { return device_.isFile() && left_[0] == 0 && left_[1] == 0; }

 private:
  Device() = default;
  Status start(const Address& address);
  Status set_modes(const Address& address);
  Status set_mode(openni::VideoStream& stream, const Mode& mode);
  Status set_registration(const Address& address);
  void find_intrinsics(const Address& address);
  void prepare_recording();

  std::string place_;
  Identity identity_;
  openni::Device device_;
  openni::VideoStream depth_stream_, colour_stream_;
  ModePair modes_;
  imaging::Registration registration_ = imaging::Registration::none;
  bool depth_mirrored_ = false, colour_mirrored_ = false, colour_is_nominal_ = false;
  Intrinsics colour_, depth_;
  std::array<std::uint64_t, 2> recorded_{}, left_{};  // depth and colour images of a recording; still to come
  std::array<int, 2> last_index_{};
  Error error_;
};

}  // namespace onemap::hal::openni2
