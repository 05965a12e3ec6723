#pragma once
// A UVC depth camera that umockdev plays: two video nodes on one USB device, with the kernel's own call interface
// (VIDIOC_*, MMAP), so that our backend runs unchanged. Its time is virtual: half a millisecond passes with each
// VIDIOC_DQBUF that finds nothing, so a slow machine loses no frames. Needs umockdev-wrapper around the process.
#include <linux/videodev2.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

struct _UMockdevTestbed;
struct _UMockdevIoctlBase;
struct _UMockdevIoctlClient;

namespace onemap::test {

// What a node has and does. Content: fills one image of the mode.
struct MockMode {
  std::uint32_t format = 0;
  std::uint32_t width = 640, height = 480;
};
std::vector<std::pair<std::uint32_t, std::uint32_t>> one_size();  // 640x480
struct MockNodeConfig {
  std::vector<std::uint32_t> formats;                                       // the first is what it falls back to
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sizes = one_size();  // the first likewise
  int fps = 30;                                                             // whatever is asked for, when fixed_rate
  bool fixed_rate = false;
  std::vector<std::uint32_t> rates;  // that it says it has, of every mode; empty: it does not say
  std::uint32_t padding_bytes = 0;   // after each row
  std::uint32_t most_buffers = 32;
  bool captures = true;                                     // else it is a metadata node
  std::int64_t phase_us = 0;                                // of its images, after the device's start
  std::uint32_t clock = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;  // that it says its stamps are of
  std::function<void(const MockMode& mode, std::uint32_t sequence, std::uint8_t* out, std::uint32_t stride)> content;
};

class MockNode;

class MockTestbed {
 public:
  MockTestbed();
  ~MockTestbed();
  static bool wrapped();  // by umockdev-wrapper
  _UMockdevTestbed* handle() const { return testbed_; }
  std::string root() const;

 private:
  _UMockdevTestbed* testbed_;
};

class MockUvc {
 public:
  // port: of USB bus 1; usb_id: "8086:0b07".
  MockUvc(MockTestbed& testbed, int port, std::string usb_id, std::string product, MockNodeConfig depth,
          MockNodeConfig colour);
  ~MockUvc();
  MockUvc(const MockUvc&) = delete;
  MockUvc& operator=(const MockUvc&) = delete;

  void on_bus(const std::string& speed, const std::string& version);  // from the next plug() on; else "480", unknown
  void plug(int first_number);  // as /dev/video<first_number> and the next; numbers that were not used before
  void unplug();
  void pause(bool paused);
  void pass(std::int64_t microseconds);          // time goes by while nobody asks
  void damage_next();                            // the next colour image is marked so
  void refuse(unsigned long request, int code);  // the next such call on the colour node fails
  void refuse_always(unsigned long request, int code);
  void vanish_at(int call);  // it no longer answers from the call after so many on, until it is plugged in again
  void hang();               // the streams that run give nothing any more; those that are begun anew do
  std::string depth_path() const { return depth_path_; }
  std::string colour_path() const { return colour_path_; }
  std::uint64_t open_buffers() const;  // of the depth node, that the driver has now
  bool streaming() const;
  bool streaming_colour() const;

 private:
  friend class MockNode;
  void add_node(MockNode& node, int number);
  const MockTestbed& testbed_;
  const int port_;
  const std::string usb_id_, product_;
  std::string speed_ = "480", version_;
  std::string depth_path_, colour_path_;
  mutable std::mutex mutex_;
  std::int64_t now_us_ = 1'000'000;
  bool paused_ = false, present_ = false;
  int until_vanished_ = -1;  // calls; negative: it stays
  std::unique_ptr<MockNode> depth_, colour_;
};

}  // namespace onemap::test
