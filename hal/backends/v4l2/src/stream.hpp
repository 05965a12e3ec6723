#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "hal/base/time.hpp"
#include "node.hpp"

namespace onemap::hal::v4l2 {

// A node that streams into buffers which the driver maps into our memory. One thread takes; any thread gives back. The
// memory stays mapped as long as somebody holds the stream, whatever became of the device.
class Stream {
 public:
  // Takes the node's descriptor. The driver may grant fewer or more buffers than are wanted.
  static constexpr std::uint32_t kFewest = 3, kMost = 32;  // buffers

  static Result<std::shared_ptr<Stream>> start(Node node, const Node::Mode& mode, std::uint32_t buffers);
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream();

  struct Image {
    std::uint32_t buffer = 0;
    std::span<const std::uint8_t> bytes;
    Duration stamp{};          // of the monotonic clock, when the image was taken
    std::string damage;        // why it cannot be used; empty when it can
    std::uint32_t missed = 0;  // images that the driver dropped before this one
  };
  enum class Taken { image, nothing, gone };
  Taken take(Image& into);  // gone: error() says why
  void give_back(std::uint32_t buffer);

  std::uint32_t with_driver() const { return with_driver_; }  // buffers that the driver can fill
  int fd() const { return fd_; }
  const Node::Mode& mode() const { return mode_; }
  const std::string& path() const { return path_; }
  const Error& error() const { return error_; }
  Error lost(const std::string& why) const { return {path_, why}; }

 private:
  struct Mapping {
    void* memory = nullptr;
    std::size_t bytes = 0;
  };
  Stream(int fd, std::string path, const Node::Mode& mode) : fd_(fd), path_(std::move(path)), mode_(mode) {}
  Status map(std::uint32_t wanted);
  Status run();

  const int fd_;
  const std::string path_;
  const Node::Mode mode_;
  std::vector<Mapping> mappings_;
  std::atomic<std::uint32_t> with_driver_ = 0;
  bool running_ = false, any_ = false;
  std::uint32_t last_sequence_ = 0;
  Error error_;
};

}  // namespace onemap::hal::v4l2
