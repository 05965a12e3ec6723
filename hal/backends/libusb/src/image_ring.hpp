#pragma once
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace onemap::hal::libusb {

enum class Stream : std::uint8_t { depth, colour };

// The memory for a device's images, taken once: libfreenect writes into a slot on its thread, and the camera's thread
// takes the filled ones, oldest first, and gives them back. When nobody takes them the oldest makes room, counted.
class ImageRing {
 public:
  struct Image {
    Stream stream = Stream::depth;
    std::uint32_t ticks = 0;
    std::uint32_t slot = 0;
    std::uint64_t number = 0;  // of the stream's images, from 0, those that made room as well
  };

  ImageRing(std::size_t depth_bytes, std::size_t colour_bytes);

  void* first_slot(Stream stream);  // where the first image goes
  // The image is filled: where the next one goes. It may be the same slot, when all others are in use.
  void* filled(Stream stream, std::uint32_t ticks);

  std::optional<Image> take(std::chrono::milliseconds timeout);
  void give_back(const Image& image);
  std::span<const std::uint8_t> bytes(const Image& image) const;

  void close();  // no more images: take() no longer waits
  bool closed() const;

 private:
  static constexpr std::size_t kSlots = 6;  // one is written, some wait for their partner, some to be taken
  struct Half {
    std::array<std::vector<std::uint8_t>, kSlots> slots;
    std::vector<std::uint32_t> free;
    std::uint32_t writing = 0;
    std::uint64_t images = 0;
  };
  Half& half(Stream stream) { return halves_[stream == Stream::depth ? 0 : 1]; }
  std::optional<std::uint32_t> slot_for_next(Stream stream);

  std::array<Half, 2> halves_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Image> ready_;
  bool closed_ = false;
};

}  // namespace onemap::hal::libusb
