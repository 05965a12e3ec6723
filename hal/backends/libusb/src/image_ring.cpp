#include "image_ring.hpp"

#include <algorithm>

namespace onemap::hal::libusb {

ImageRing::ImageRing(std::size_t depth_bytes, std::size_t colour_bytes) {
  for (const auto& [stream, bytes] : {std::pair(Stream::depth, depth_bytes), {Stream::colour, colour_bytes}}) {
    for (auto& slot : half(stream).slots) slot.resize(bytes);
    for (std::uint32_t slot = 1; slot < kSlots; ++slot) half(stream).free.push_back(slot);
  }
}

void* ImageRing::first_slot(Stream stream) { return half(stream).slots[0].data(); }

void* ImageRing::filled(Stream stream, std::uint32_t ticks) {
  const std::lock_guard lock(mutex_);
  Half& of = half(stream);
  const std::uint64_t number = of.images++;
  if (const auto next = slot_for_next(stream)) {
    ready_.push_back({stream, ticks, of.writing, number});
    of.writing = *next;
    changed_.notify_all();
  }
  return of.slots[of.writing].data();
}

std::optional<std::uint32_t> ImageRing::slot_for_next(Stream stream) {
  Half& of = half(stream);
  if (!of.free.empty()) {
    const std::uint32_t slot = of.free.back();
    of.free.pop_back();
    return slot;
  }
  const auto oldest = std::ranges::find(ready_, stream, &Image::stream);
  if (oldest == ready_.end()) return std::nullopt;
  const std::uint32_t slot = oldest->slot;
  ready_.erase(oldest);
  return slot;
}

std::optional<ImageRing::Image> ImageRing::take(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [&] { return closed_ || !ready_.empty(); });
  if (ready_.empty()) return std::nullopt;
  const Image image = ready_.front();
  ready_.pop_front();
  return image;
}

void ImageRing::give_back(const Image& image) {
  const std::lock_guard lock(mutex_);
  half(image.stream).free.push_back(image.slot);
}

std::span<const std::uint8_t> ImageRing::bytes(const Image& image) const {
  return halves_[image.stream == Stream::depth ? 0 : 1].slots[image.slot];
}

void ImageRing::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

bool ImageRing::closed() const {
  const std::lock_guard lock(mutex_);
  return closed_ && ready_.empty();
}

}  // namespace onemap::hal::libusb
