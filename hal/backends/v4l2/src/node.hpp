#pragma once
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats.hpp"
#include "hal/base/result.hpp"
#include "hal/imaging/image_size.hpp"

namespace onemap::hal::v4l2 {

// An ioctl that is repeated when a signal interrupts it: 0, or errno.
int control(int fd, unsigned long request, void* argument);

// An open video node before it streams: what it can do, and the choice of a mode. Errors name the node.
class Node {
 public:
  static Result<Node> open(const std::string& path);
  // The reason of open()'s error for what is no camera: metadata nodes, of which each camera has some, and outputs.
  static constexpr std::string_view kNoCapture = "does not capture video (a metadata node?)";
  Node(Node&& other) noexcept;
  Node& operator=(Node&&) = delete;
  Node(const Node&) = delete;
  ~Node();

  const std::string& path() const { return path_; }
  const std::string& card() const { return card_; }
  std::vector<FourCc> formats() const;
  // For people: "640x480 848x480", or "any from .. to ..".
  std::string sizes(FourCc format) const;

  // Whole frames a second of a mode, the most first; empty: the driver does not say.
  std::vector<int> rates(FourCc format, imaging::ImageSize size) const;
  // Whether the driver says that it has this size; true when it does not say its sizes.
  bool has_size(FourCc format, imaging::ImageSize size) const;

  struct Mode {
    FourCc format = 0;
    imaging::ImageSize size;
    std::size_t stride_bytes = 0;
    std::size_t image_bytes = 0;
  };
  // Drivers put what they like in place of what they cannot do, without a word: whatever comes back different is an
  // error that says both.
  Result<Mode> set_mode(FourCc format, imaging::ImageSize size, int fps) const;
  int release();  // the file descriptor, now the caller's

 private:
  Node(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}
  Status set_rate(int fps) const;
  Error error(const std::string& what, int code) const;
  int fd_;
  std::string path_, card_;
};

}  // namespace onemap::hal::v4l2
