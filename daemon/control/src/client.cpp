#include "control/client.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace onemap::control {

namespace {
using Clock = std::chrono::steady_clock;

// Whether the socket is ready within the time.
bool await(int socket, short events, Duration patience) {
  pollfd waited{socket, events, 0};
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(patience).count();
  int got = 0;
  do got = poll(&waited, 1, static_cast<int>(std::max<std::int64_t>(0, ms)));
  while (got < 0 && errno == EINTR);
  return got > 0;
}

Status check_greeting(const Json& greeting) {
  if (greeting.value("class", "") != "VERSION") return Error{"", "this is no onemapd: it says no VERSION"};
  const int major = greeting.value("protocol", 0);
  if (major == kProtocolMajor) return success();
  return Error{"",
               fmt::format("onemapd {} speaks protocol {}, this onemapctl speaks {}: install the same version of both",
                           greeting.value("version", "?"), major, kProtocolMajor)};
}
}  // namespace

std::string why_no_daemon(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
      return "there is nothing; is onemapd running (systemctl status onemapd)? Its log says where its control socket "
             "is; "
             "say --socket PATH";
    case ECONNREFUSED:
      return "nobody listens: onemapd has ended or was killed, or this is no socket of it; see its log (journalctl -u "
             "onemapd)";
    case EACCES:
    case EPERM:
      return "permission denied: you may not enter the folder; join its group, or use sudo";
    case EAGAIN:
      return "too many wait there already; try again";
    case ENOTSOCK:
      return "this is no socket";
    default:
      return fmt::format("cannot connect to {}: {}", path, std::strerror(error));
  }
}

ControlClient::ControlClient(ControlClient&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      path_(std::move(other.path_)),
      reader_(std::move(other.reader_)),
      greeting_(std::move(other.greeting_)),
      last_id_(other.last_id_) {}

ControlClient::~ControlClient() {
  if (socket_ >= 0) ::close(socket_);
}

Result<ControlClient> ControlClient::connect(const std::string& path, Duration patience) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return Error{path, "is longer than a socket's path may be (107 bytes)"};
  path.copy(address.sun_path, path.size());
  ControlClient client(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0), path);
  if (client.socket_ < 0) return Error{path, std::strerror(errno)};
  const timeval limit{static_cast<time_t>(to_seconds(patience)) + 1, 0};  // connect() waits where many wait already
  (void)setsockopt(client.socket_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  if (::connect(client.socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return Error{path, why_no_daemon(path, errno)};
  auto greeting = client.receive(patience);
  if (!greeting) return greeting.error();
  if (auto good = check_greeting(*greeting); !good) return Error{path, good.error().reason};
  client.greeting_ = std::move(*greeting);
  return client;
}

Status ControlClient::send(const Json& request) {
  const std::string line = line_of(request);
  for (std::size_t sent = 0; sent < line.size();) {
    const ssize_t count = ::send(socket_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return Error{path_, std::string("the daemon is gone: ") + std::strerror(errno)};
    sent += static_cast<std::size_t>(count);
  }
  return success();
}

Status ControlClient::read_some(Duration patience) {
  if (!await(socket_, POLLIN, patience))
    return Error{path_, "the daemon does not answer (is it stopped, or very busy?)"};
  std::array<char, 16384> bytes;  // NOLINT(cppcoreguidelines-pro-type-member-init): written by recv
  const ssize_t got = recv(socket_, bytes.data(), bytes.size(), 0);
  if (got < 0 && errno == EINTR) return success();
  if (got < 0) return Error{path_, std::strerror(errno)};
  if (got == 0) return Error{path_, "the daemon closed the connection: it ended, or dropped this client (see its log)"};
  reader_.add({bytes.data(), static_cast<std::size_t>(got)});
  return success();
}

Result<Json> ControlClient::receive(Duration patience) {
  const auto end = Clock::now() + patience;
  for (LineReader::Line line;;) {
    while (!reader_.next(line))
      if (auto read = read_some(end - Clock::now()); !read) return read.error();
    if (line.too_long) return Error{path_, "an answer is longer than 8 MiB"};
    Json object = Json::parse(line.text, nullptr, false);
    if (!object.is_object()) return Error{path_, "the daemon's answer is no JSON object"};
    return object;
  }
}

Result<Json> ControlClient::ask(Json request, Duration patience) {
  const int id = ++last_id_;
  request["id"] = id;
  if (auto sent = send(request); !sent) return sent.error();
  const auto end = Clock::now() + patience;
  for (;;) {
    auto object = receive(end - Clock::now());
    if (!object) return object.error();
    const auto answered = object->find("id");
    const std::string name = object->value("class", "");
    if (name == "ERROR" && (answered == object->end() || *answered == id))
      return Error{"", object->value("message", "refused, for no reason")};
    if (answered == object->end() || *answered != id || name == "ACK") continue;
    return object;
  }
}

}  // namespace onemap::control
