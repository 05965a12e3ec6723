#pragma once
#include <string>
#include <string_view>

namespace onemap::hal::openni2 {

// Why the USB device that a driver's URI names, VENDOR/PRODUCT@BUS/DEVICE, cannot be used, as far as the kernel tells
// it without opening it: we may not, or its port is slower than USB 2's 480 Mbit/s. Empty when it can, or when the URI
// names none. root: where /dev and /sys are.
std::string usb_problem(std::string_view uri, const std::string& root = "");

}  // namespace onemap::hal::openni2
