#pragma once
#include <string>
#include <vector>

namespace onemap::hal::v4l2 {

// A video node as sysfs tells of it, without opening it.
struct NodePlace {
  std::string path;       // /dev/videoN; the number changes when the device is plugged in again
  std::string interface;  // sysfs folder of the device's function that it belongs to: stays the same at one port
  int index = 0;          // among the nodes of this function
  std::string device;     // sysfs folder of the USB device (or what else it is): all nodes of one body share it
  std::string name;       // as the driver calls it
  std::string usb_id;     // "8086:0b07"; empty when it is no USB device
  std::string product, serial;
  std::string speed;        // of the bus in Mbit/s, as sysfs has it; empty when unknown
  std::string usb_version;  // the device's own, as it says on this bus ("2.10" of a USB 3 device on USB 2)

  bool same_socket(const NodePlace& other) const { return interface == other.interface && index == other.index; }
};

// Every video node of this machine, by its number.
std::vector<NodePlace> find_nodes();

}  // namespace onemap::hal::v4l2
