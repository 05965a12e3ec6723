#include "daemon/pose_streams.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "daemon/outputs.hpp"

namespace onemap::daemon {

namespace {

constexpr int kWaiting = 8;  // connections that were not greeted yet

Error failed(const std::string& path, const char* what) {
  return Error{path, fmt::format("{}: {}", what, std::generic_category().message(errno))};
}

// A socket that a killed daemon left answers nobody.
bool is_left_over(const std::string& path, const sockaddr_un& address) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0 || !S_ISSOCK(found.st_mode)) return false;
  const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (probe < 0) return false;
  const bool refused =
      ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 && errno == ECONNREFUSED;
  ::close(probe);
  return refused;
}

bool send_whole(int reader, const std::string& line) {
  return ::send(reader, line.data(), line.size(), MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(line.size());
}

}  // namespace

Result<PoseStreams> PoseStreams::open(const std::string& path) {
  PoseStreams streams;
  const char* frames[] = {"odom", "map"};
  for (std::size_t i = 0; i < 2; ++i) {
    Stream& stream = streams.streams_[i];
    stream.frame = frames[i];
    auto listener = listen_at(path + "." + stream.frame);
    if (!listener) return listener.error();
    stream.path = path + "." + stream.frame;  // ours from now on
    stream.listener = *listener;
  }
  return Result<PoseStreams>(std::move(streams));
}

Result<int> PoseStreams::listen_at(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    return Error{path, fmt::format("is longer than a socket's name can be ({} bytes)", sizeof address.sun_path - 1)};
  path.copy(address.sun_path, path.size());
  if (is_left_over(path, address)) ::unlink(path.c_str());
  const int listener = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listener < 0) return failed(path, "no socket");
  if (::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listener, kWaiting) != 0) {
    const Error error = failed(path, "cannot listen");
    ::close(listener);
    return error;
  }
  ::chmod(path.c_str(), 0660);
  return listener;
}

PoseStreams::PoseStreams(PoseStreams&& other) noexcept
    : streams_(std::exchange(other.streams_, {})),
      readers_(other.readers_.load()),
      lines_(other.lines_.load()),
      dropped_(other.dropped_.load()) {}

PoseStreams::~PoseStreams() {
  for (Stream& stream : streams_) {
    for (const int reader : stream.readers) ::close(reader);
    if (stream.listener < 0) continue;
    ::close(stream.listener);
    ::unlink(stream.path.c_str());
  }
}

void PoseStreams::greet(Stream& stream) {
  for (;;) {
    const int reader = ::accept4(stream.listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (reader < 0) return;
    const bool room = stream.readers.size() < kReaders;
    if (room && send_whole(reader, fmt::format("# time tx ty tz qx qy qz qw: T_{}_camera\n", stream.frame))) {
      stream.readers.push_back(reader);
    } else {
      ::close(reader);
      ++dropped_;
    }
  }
}

void PoseStreams::say(Stream& stream, const std::string& line) {
  std::erase_if(stream.readers, [&](int reader) {
    if (send_whole(reader, line)) return false;
    const bool left = errno == EPIPE || errno == ECONNRESET;  // of its own will
    if (!left) ++dropped_;
    ::close(reader);
    return true;
  });
}

void PoseStreams::count() { readers_ = streams_[0].readers.size() + streams_[1].readers.size(); }

void PoseStreams::say(const RecordedPose& pose) {
  for (Stream& stream : streams_) greet(stream);
  say(streams_[0], pose_line(pose.time, pose.T_odom_camera));
  if (pose.T_map_odom) say(streams_[1], pose_line(pose.time, *pose.T_map_odom * pose.T_odom_camera));
  ++lines_;
  count();
}

}  // namespace onemap::daemon
