#pragma once
#include <string>
#include <vector>

#include "address.hpp"
#include "hal/imaging/rig_calibration.hpp"
#include "node.hpp"
#include "sysfs.hpp"

namespace onemap::hal::v4l2 {

// A camera's two nodes, found but not streaming.
struct Device {
  NodePlace depth, colour;
  FourCc depth_format = 0, colour_format = 0;
};

// The depth node that the address names, or the machine's first Z16 node; with the colour node that the address names,
// or the one with the best colours on the same device.
Result<Device> find_device(const V4l2Address& address);

// The nodes at the same sockets as before: a device that was plugged in again has other numbers. Another device there
// is an error, for its lenses are others.
Result<Device> find_again(const Device& device);

// Why the device does less at its port than it could, and what to do; empty: it does not. For people.
std::string limits_of(const NodePlace& node);

// The file that the address names, else the shipped nominal calibration of the model. source: for people.
Result<imaging::RigCalibration> calibration_of(const V4l2Address& address, const Device& device, std::string& source);

}  // namespace onemap::hal::v4l2
