#pragma once
#include <linux/videodev2.h>
#include <umockdev.h>

#include <deque>
#include <string>

#include "mock_uvc.hpp"

namespace onemap::test {

// One node: the driver's side of the V4L2 calls. All state is guarded by the device's mutex.
class MockNode {
 public:
  MockNode(MockUvc& device, MockNodeConfig config);
  ~MockNode() { detach(); }

  void attach(const std::string& path, const std::string& file);
  void detach();
  int call(unsigned long request, std::uint8_t* argument);  // 0, or errno
  static gboolean on_ioctl(UMockdevIoctlBase* base, UMockdevIoctlClient* client);
  bool streaming() const { return streaming_; }
  std::size_t queued() const { return queued_.size(); }

  bool damage_next = false;
  unsigned long refused_request = 0;
  int refused_code = 0;
  bool refuses_always = false;
  bool hangs = false;

 private:
  std::uint32_t row_bytes() const { return mode_.width * 2; }
  std::uint32_t stride() const { return row_bytes() + config_.padding_bytes; }
  std::uint32_t image_bytes() const { return stride() * mode_.height; }
  std::uint32_t slot_bytes() const { return (image_bytes() + 4095u) / 4096u * 4096u; }
  bool wants(std::uint32_t format, std::uint32_t width, std::uint32_t height) const;
  int set_format(v4l2_format& f);
  int enumerate_sizes(v4l2_frmsizeenum& s) const;
  int enumerate_rates(v4l2_frmivalenum& v) const;
  int choose(unsigned long request, std::uint8_t* argument);
  int stream(unsigned long request, std::uint8_t* argument);
  int describe(v4l2_capability& v) const;
  int enumerate_formats(v4l2_fmtdesc& v) const;
  int set_rate(v4l2_streamparm& v, bool wanted);
  int request_buffers(v4l2_requestbuffers& r);
  int describe(v4l2_buffer& v) const;
  int queue(std::uint32_t index);
  int take(v4l2_buffer& b);
  void produce();
  void forget();

  MockUvc& device_;
  const MockNodeConfig config_;
  UMockdevIoctlBase* handler_ = nullptr;
  std::string path_, file_;
  MockMode mode_;
  int fps_ = 30;
  std::uint8_t* memory_ = nullptr;
  std::size_t memory_bytes_ = 0;
  std::uint32_t buffers_ = 0, sequence_ = 0;
  struct Done {
    std::uint32_t index, sequence, flags;
    std::int64_t time_us;
  };
  std::deque<std::uint32_t> queued_;
  std::deque<Done> done_;
  bool streaming_ = false;
  std::int64_t next_us_ = 0;
};

}  // namespace onemap::test
