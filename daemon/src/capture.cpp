#include "daemon/capture.hpp"

#include <utility>

#include "daemon/clock.hpp"

namespace onemap::daemon {

namespace {
constexpr std::size_t kQueued = 3;
constexpr std::size_t kFrames = kQueued + 2;  // one being filled, one being processed: the pool never runs dry
constexpr auto kPatience = std::chrono::milliseconds(100);
constexpr auto kLate = std::chrono::seconds(2);  // a recording that is later than this waited, too: it is not caught up
constexpr auto kStuckAfter = std::chrono::seconds(20);  // a driver may take its time to open a camera that came back
}  // namespace

Capture::Capture(hal::DepthCamera& camera, Speed speed, Failures& failures, Log& log)
    : camera_(camera),
      speed_(speed),
      failures_(failures),
      log_(log),
      pool_(camera.intrinsics(), kFrames),
      queue_(kQueued),
      live_(camera.live()),
      words_{camera.description(), camera.limits()},
      heartbeat_("capture", kStuckAfter) {
  read_counters();
}

Capture::~Capture() { stop(); }

std::uint64_t Capture::bytes_of(const hal::Intrinsics& camera) {
  constexpr std::uint64_t kPixelBytes = 3 + sizeof(std::uint16_t);
  return kFrames * kPixelBytes * static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
}

void Capture::start() {
  thread_.start(
      "capture", failures_, [this] { run(); }, [this] { queue_.close(); });
}

void Capture::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  queue_.close();
  thread_.join();
}

void Capture::run() {
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      if (stopping_) break;
    }
    hal::Frame frame = pool_.acquire();
    heartbeat_.beat(now());
    const hal::Grab grab = camera_.grab(frame, kPatience);
    heartbeat_.rest();  // for the pace and the pipeline it waits as long as they want
    read_counters();
    if (grab == hal::Grab::end) {
      ended_ = true;
      break;
    }
    tell(grab);
    if (grab != hal::Grab::frame) continue;
    ++grabbed_;
    if (!usable(frame)) continue;
    if (!keep_pace(frame.colour_time)) break;
    if (listener_) listener_(frame.view());
    if (!deliver(std::move(frame))) break;
  }
}

void Capture::read_counters() {
  const hal::CameraCounters counted = camera_.counters();
  unmatched_ = counted.unmatched;
  missed_ = counted.missed;
}

void Capture::tell(hal::Grab grab) {
  if (grab == hal::Grab::bad) {
    ++bad_;
    log_.limited("bad frame", "frame refused: {}", camera_.last_error().text());
  } else if (grab == hal::Grab::gone && !away_) {
    away_ = true;
    ++gone_;
    why_away_ = camera_.last_error().text();
    log_.warn("the camera is gone: {}; waiting for it: look at its cable and power", why_away_);
  } else if (grab == hal::Grab::gone && camera_.last_error().text() != why_away_) {
    const std::string why = camera_.last_error().text();  // it may be there, and not as it was
    if (log_.limited("camera away", "the camera is still gone: {}", why)) why_away_ = why;
  } else if (grab == hal::Grab::frame && away_) {
    away_ = false;
    log_.line("the camera is back");
    read_words();
  }
}

void Capture::read_words() {
  CameraWords words{camera_.description(), camera_.limits()};
  if (words == words_) return;
  if (words.description != words_.description) log_.line("camera {}", words.description);
  if (words.limits != words_.limits) {
    if (words.limits.empty())
      log_.line("nothing limits the camera any more");
    else
      log_.warn("the camera {}", words.limits);
  }
  const std::lock_guard lock(mutex_);
  words_ = std::move(words);
}

CameraWords Capture::words() const {
  const std::lock_guard lock(mutex_);
  return words_;
}

bool Capture::times_increase(hal::Frame& frame) {
  using Verdict = FrameTimes::Verdict;
  const FrameTime came = frame.colour_time;
  const Verdict verdict = times_.take(frame.colour_time, frame.depth_time);
  time_back_ = times_.refused();
  if (verdict == Verdict::refused)
    log_.limited(
        "time back",
        "frame {} refused: its time, {:.3f} s, is not after the one before it; the camera's or the recording's "
        "stamps are wrong: look for a newer driver, or record it anew",
        frame.index, to_seconds(came));
  if (verdict == Verdict::moved)
    log_.warn(
        "the camera's clock was set back: its times are moved by {:.3f} s from here on; restart the daemon when "
        "they shall be its own again",
        to_seconds(times_.shift()));
  if (verdict == Verdict::returned) log_.line("the camera's clock is ahead again: its times are its own");
  return verdict != Verdict::refused;
}

bool Capture::usable(hal::Frame& frame) {
  if (!times_increase(frame)) return false;
  const FrameCheck::Seen seen = check_.look(frame.view());
  for (std::size_t i = 0; i < kFrameFaults; ++i) faults_[i] = check_.frames(static_cast<FrameFault>(i));
  if (!seen.began.empty()) log_.warn("frame {}: {}", frame.index, seen.began);
  if (!seen.ended.empty()) log_.line("the camera is well again at frame {}: {}", frame.index, seen.ended);
  return !seen.frozen;
}

bool Capture::deliver(hal::Frame frame) {
  return speed_.max ? queue_.push(std::move(frame)) : queue_.push_dropping_oldest(std::move(frame));
}

bool Capture::keep_pace(FrameTime time) {
  if (speed_.max || live_) return true;
  if (!paced_) {
    paced_ = true;
    origin_ = now();
    origin_frame_ = time;
  }
  const Duration due(static_cast<std::int64_t>(static_cast<double>((time - origin_frame_).count()) / speed_.factor));
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const Duration left = origin_ + due - now();
    if (left < -kLate) origin_ = now() - due;
    if (left <= Duration::zero()) break;
    wake_.wait_for(lock, left);
  }
  return !stopping_;
}

CaptureCounters Capture::counters() const {
  const auto fault = [&](FrameFault f) { return faults_[static_cast<std::size_t>(f)].load(); };
  return {grabbed_,
          bad_,
          queue_.dropped(),
          gone_,
          fault(FrameFault::frozen),
          fault(FrameFault::black),
          fault(FrameFault::saturated),
          fault(FrameFault::no_depth),
          time_back_,
          unmatched_,
          missed_};
}

}  // namespace onemap::daemon
