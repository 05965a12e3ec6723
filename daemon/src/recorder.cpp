#include "daemon/recorder.hpp"

#include <sys/statvfs.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "daemon/outputs.hpp"

namespace onemap::daemon {

namespace {

double megabytes(std::uint64_t bytes) { return static_cast<double>(bytes) / (1u << 20); }

// What somebody without privileges may still write; without an answer: as much as there could be.
std::uint64_t free_bytes(const std::string& folder) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0) return UINT64_MAX;
  return static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
}

}  // namespace

RecorderConfig recorder_config(const Config& config) {
  const auto writes = [&](const char* format) { return std::ranges::count(config.record.formats, format) > 0; };
  return {config.record.limit_bytes, config.record.least_free_bytes, writes("tum"), writes("mcap"), config.speed.max};
}

std::string next_recording(const std::string& out) {
  std::error_code none;
  for (unsigned number = 1;; ++number)
    if (std::string folder = fmt::format("{}/recordings/{:04}", out, number); !std::filesystem::exists(folder, none))
      return folder;
}

Recorder::Recorder(const RecorderConfig& config, RecordedCamera camera, TruthLine truth, Log& log)
    : config_(config), camera_(std::move(camera)), truth_(std::move(truth)), log_(log) {}

Recorder::~Recorder() { stop(); }

Status Recorder::start(const std::string& folder) {
  const std::lock_guard control(control_);
  if (const RecorderView now = view(); now.recording)
    return Error{folder, "a recording is running, in " + now.folder + ": stop it first"};
  if (auto made = make_folder(folder); !made) return made;
  const std::uint64_t least = config_.least_free_bytes;
  if (const std::uint64_t left = free_bytes(folder); left < least)
    return Error{folder, fmt::format("{:.0f} MB are free on the disk, fewer than record.least_free_mb = {:.0f}",
                                     megabytes(left), megabytes(least))};
  auto session = std::make_shared<Session>(folder, camera_.intrinsics);
  if (auto opened = open(*session); !opened) return opened;
  std::shared_ptr<Session> last;  // its thread is joined without the lock
  {
    const std::lock_guard lock(mutex_);
    last = std::exchange(session_, session);
    view_ = {true, folder, 0, 0, 0, {}};
  }
  if (last) last->queue.close();
  recording_ = true;
  session->thread.start("recorder", failures_, [this, session = session.get()] { run(*session); });
  log_.line("recording to {}", folder);
  return success();
}

Status Recorder::open(Session& session) const {
  if (config_.tum) {
    auto writer = RecordingWriter::open(session.folder, camera_, truth_);
    if (!writer) return writer.error();
    session.tum.emplace(std::move(*writer));
  }
  if (!config_.mcap) return success();
  auto writer = McapRecording::create(session.folder + "/recording.mcap");
  if (!writer) return writer.error();
  session.mcap.emplace(std::move(*writer));
  return success();
}

RecorderView Recorder::stop() {
  const std::lock_guard control(control_);
  std::shared_ptr<Session> session;
  {
    const std::lock_guard lock(mutex_);
    if (!session_) return view_;
    session = session_;
  }
  session->open = false;
  session->queue.close();
  session->thread.join();
  const RecorderView last = view();
  {
    const std::lock_guard lock(mutex_);
    view_ = last;
    view_.recording = false;
    recording_ = false;
    session_.reset();
  }
  if (last.recording)
    log_.line("recorded {} frames ({:.1f} MB) to {}, {} dropped", last.frames, megabytes(last.bytes), last.folder,
              last.dropped);
  return view();
}

RecorderView Recorder::view() const {
  const std::lock_guard lock(mutex_);
  RecorderView view = view_;
  if (!session_) return view;
  view.frames = session_->frames;
  view.bytes = session_->bytes;
  view.dropped = session_->dropped;
  return view;
}

void Recorder::offer(const hal::FrameView& frame) {
  std::shared_ptr<Session> session;
  {
    const std::lock_guard lock(mutex_);
    session = session_;
  }
  if (!session || !session->open) return;
  hal::Frame copy = config_.every_frame ? session->pool.acquire() : session->pool.try_acquire();
  if (!copy) {
    const std::uint64_t dropped = ++session->dropped;
    if (dropped == 1 || dropped == 100 || dropped % 1000 == 0)
      log_.warn(
          "recording is slower than the camera: {} frames of it dropped so far; record to a faster disk "
          "(robot.out), one of record.formats alone, or end what else keeps this machine busy",
          dropped);
    return;
  }
  copy.colour_time = frame.colour_time;
  copy.depth_time = frame.depth_time;
  copy.index = frame.index;
  std::ranges::copy(frame.rgb, copy.rgb().begin());
  std::ranges::copy(frame.depth, copy.depth().begin());
  session->queue.push(std::move(copy));  // there is room: the queue is as long as the pool
}

void Recorder::pose(const RecordedPose& pose) {
  std::shared_ptr<Session> session;
  {
    const std::lock_guard lock(mutex_);
    session = session_;
  }
  if (!session || !session->open || !config_.mcap) return;
  const std::lock_guard lock(session->pose_mutex);
  if (session->poses.size() == kPoses) session->poses.pop_front();
  session->poses.push_back(pose);
}

void Recorder::run(Session& session) {
  bool ended = false;
  while (auto frame = session.queue.pop()) {
    if (ended) continue;  // what is queued is nobody's
    const auto written = guarded("recorder", [&] { return write(session, frame->view()); });
    session.bytes = (session.tum ? session.tum->bytes() : 0) + (session.mcap ? session.mcap->bytes() : 0);
    ended = !written;
    if (ended) end(session, written.error());
  }
  if (!session.mcap) return;
  const auto finished = guarded("recorder", [&] {
    if (auto written = write_poses(session); !written) return written;
    return session.mcap->finish();
  });
  if (!finished && !ended) end(session, finished.error());
  session.bytes = (session.tum ? session.tum->bytes() : 0) + session.mcap->bytes();
}

Status Recorder::write(Session& session, const hal::FrameView& frame) {
  if (auto there = room(session); !there) return there;
  if (session.tum)
    if (auto written = session.tum->write(frame); !written) return written;
  if (session.mcap) {
    if (auto written = session.mcap->write(frame); !written) return written;
    if (auto written = write_poses(session); !written) return written;
  }
  ++session.frames;
  return success();
}

Status Recorder::write_poses(Session& session) {
  std::deque<RecordedPose> poses;
  {
    const std::lock_guard lock(session.pose_mutex);
    poses.swap(session.poses);
  }
  for (const RecordedPose& pose : poses)
    if (auto written = session.mcap->write(pose); !written) return written;
  return success();
}

Status Recorder::room(const Session& session) const {
  if (session.bytes >= config_.limit_bytes)
    return Error{session.folder,
                 fmt::format("it has {:.0f} MB, which is record.limit_mb", megabytes(config_.limit_bytes))};
  const std::uint64_t left = free_bytes(session.folder);
  if (left >= config_.least_free_bytes) return success();
  return Error{session.folder,
               fmt::format("{:.0f} MB are left on the disk, fewer than record.least_free_mb", megabytes(left))};
}

void Recorder::end(Session& session, const Error& why) {
  session.open = false;
  recording_ = false;
  log_.warn("the recording ended after {} frames: {}; make room, or raise that, then `onemapctl record start`",
            session.frames.load(), why.text());
  const std::lock_guard lock(mutex_);
  if (session_.get() != &session) return;
  view_.recording = false;
  view_.ended = why.text();
}

}  // namespace onemap::daemon
