#pragma once
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "hal/frame.hpp"

namespace onemap::hal {

class FramePool;

// Depth that lies in a device's own memory, height x width values: shown by a frame instead of the pool's, so that it
// is not copied. When the frame ends, on whatever thread that is, the lender gets the buffer back.
struct DepthLoan {
  std::span<const std::uint16_t> depth;
  std::shared_ptr<void> lender;  // keeps the memory in place while a frame shows it
  void (*give_back)(void* lender, std::uint32_t buffer) = nullptr;
  std::uint32_t buffer = 0;
};

// A frame's memory on loan from the pool; returns it when destroyed. Moves, never copies.
class Frame {
 public:
  Frame() = default;
  Frame(Frame&& other) noexcept;
  Frame& operator=(Frame&& other) noexcept;
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;
  ~Frame();

  explicit operator bool() const { return pool_ != nullptr; }
  FrameTime colour_time{}, depth_time{};
  std::uint64_t index = 0;
  std::span<std::uint8_t> rgb() const;
  std::span<std::uint16_t> depth() const;  // the pool's memory, whether or not something is borrowed
  void borrow(DepthLoan loan);             // until the frame ends or depth is borrowed or returned anew
  void return_loan();
  FrameView view() const;  // of the borrowed depth, if there is any

 private:
  friend class FramePool;
  Frame(FramePool* pool, std::size_t slot) : pool_(pool), slot_(slot) {}
  void release();
  FramePool* pool_ = nullptr;
  std::size_t slot_ = 0;
  DepthLoan loan_;
};

// A fixed number of frame buffers, allocated once. Thread safe. It must outlive its frames.
class FramePool {
 public:
  FramePool(const Intrinsics& intrinsics, std::size_t frames);
  FramePool(const FramePool&) = delete;
  FramePool& operator=(const FramePool&) = delete;
  ~FramePool();

  Frame acquire();      // waits until a slot is free
  Frame try_acquire();  // an empty one when there is none
  const Intrinsics& intrinsics() const { return intrinsics_; }
  std::size_t capacity() const { return slots_; }
  std::size_t used() const;
  std::size_t bytes() const;

 private:
  friend class Frame;
  Frame take();  // with mutex_
  void release(std::size_t slot);
  const Intrinsics intrinsics_;
  const std::size_t slots_;
  std::unique_ptr<std::uint8_t[]> rgb_;
  std::unique_ptr<std::uint16_t[]> depth_;
  mutable std::mutex mutex_;
  std::condition_variable freed_;
  std::vector<std::size_t> free_;
};

}  // namespace onemap::hal
