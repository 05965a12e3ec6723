#pragma once
#include <filesystem>
#include <string>

namespace onemap::test {

// A device of the test driver is a file NAME.device in the folder that the environment's ONEMAP_TEST_DEVICES names,
// with lines `key value`. Making the file plugs the device in (write it elsewhere and rename it), removing it pulls it
// out.
struct DeviceFile {
  std::string room = "simulated:living-room";  // what it sees
  double hz = 30;                              // pace of real time; its stamps are the room's
  bool steps = false;                          // not a pace, but one picture for each byte in the FIFO NAME.steps
  bool on_demand = false;      // not a pace, but a picture when somebody waits for one and there is no file NAME.paused
  bool registers = true;       // offers depth registered to colour; else depth is seen from 25 mm to the left
  bool hundred_um = false;     // depth in 100 um; else in mm
  bool clock_restarts = true;  // its stamps start again when it is plugged in again; else they go on
  int depth_late_us = 0;       // how much later than colour depth is stamped
  bool substitutes = false;    // says that it takes a video mode and takes another
  bool unheard = false;        // the driver sees it when it begins, and does not hear it come later
  std::string colour;          // its only form of colour: rgb, yuv422, yuyv, grey or jpeg; empty: two
  std::string serial = "TEST1";
};

// Unknown keys and values that are not numbers throw std::runtime_error with file and line.
DeviceFile read_device_file(const std::filesystem::path& file);

}  // namespace onemap::test
