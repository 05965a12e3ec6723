#include "hal/frame_pool.hpp"

#include <cassert>
#include <utility>

namespace onemap::hal {

namespace {
std::size_t pixels(const Intrinsics& k) {
  return static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
}
}  // namespace

Frame::Frame(Frame&& other) noexcept
    : colour_time(other.colour_time),
      depth_time(other.depth_time),
      index(other.index),
      pool_(std::exchange(other.pool_, nullptr)),
      slot_(other.slot_),
      loan_(std::exchange(other.loan_, {})) {}

Frame& Frame::operator=(Frame&& other) noexcept {
  if (this == &other) return *this;
  release();
  colour_time = other.colour_time;
  depth_time = other.depth_time;
  index = other.index;
  slot_ = other.slot_;
  pool_ = std::exchange(other.pool_, nullptr);
  loan_ = std::exchange(other.loan_, {});
  return *this;
}

Frame::~Frame() { release(); }

void Frame::release() {
  return_loan();
  if (pool_) pool_->release(slot_);
}

void Frame::borrow(DepthLoan loan) {
  assert(pool_ && loan.depth.size() == pixels(pool_->intrinsics_) && loan.give_back);
  return_loan();
  loan_ = std::move(loan);
}

void Frame::return_loan() {
  if (loan_.give_back) loan_.give_back(loan_.lender.get(), loan_.buffer);
  loan_ = {};
}

std::span<std::uint8_t> Frame::rgb() const {
  assert(pool_);
  const std::size_t n = 3 * pixels(pool_->intrinsics_);
  return {pool_->rgb_.get() + slot_ * n, n};
}

std::span<std::uint16_t> Frame::depth() const {
  assert(pool_);
  const std::size_t n = pixels(pool_->intrinsics_);
  return {pool_->depth_.get() + slot_ * n, n};
}

FrameView Frame::view() const {
  return {colour_time, depth_time, index, &pool_->intrinsics_, rgb(), loan_.give_back ? loan_.depth : depth()};
}

FramePool::FramePool(const Intrinsics& intrinsics, std::size_t frames)
    : intrinsics_(intrinsics),
      slots_(frames),
      rgb_(std::make_unique<std::uint8_t[]>(3 * pixels(intrinsics) * frames)),
      depth_(std::make_unique<std::uint16_t[]>(pixels(intrinsics) * frames)) {
  free_.reserve(frames);
  for (std::size_t slot = frames; slot > 0; --slot) free_.push_back(slot - 1);
}

FramePool::~FramePool() { assert(free_.size() == slots_ && "a frame outlives its pool"); }

Frame FramePool::acquire() {
  std::unique_lock lock(mutex_);
  freed_.wait(lock, [&] { return !free_.empty(); });
  return take();
}

Frame FramePool::try_acquire() {
  const std::lock_guard lock(mutex_);
  if (free_.empty()) return {};
  return take();
}

Frame FramePool::take() {
  const std::size_t slot = free_.back();
  free_.pop_back();
  return {this, slot};
}

void FramePool::release(std::size_t slot) {
  {
    std::unique_lock lock(mutex_);
    free_.push_back(slot);
  }
  freed_.notify_one();
}

std::size_t FramePool::used() const {
  std::unique_lock lock(mutex_);
  return slots_ - free_.size();
}

std::size_t FramePool::bytes() const { return slots_ * pixels(intrinsics_) * 5; }

}  // namespace onemap::hal
