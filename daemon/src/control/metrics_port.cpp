#include "daemon/control/metrics_port.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <vector>

namespace onemap::daemon {

namespace {
constexpr std::size_t kMostVisitors = 16, kMostRequestBytes = 4096;
constexpr int kMostSeconds = 10;

std::string answer(const char* status, const std::string& body, const char* more = "") {
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\nContent-Length: {}\r\nConnection: "
      "close\r\n{}\r\n{}",
      status, body.size(), more, body);
}
}  // namespace

std::string http_answer(const std::string& request, const std::function<std::string()>& text) {
  const std::string line = request.substr(0, request.find("\r\n"));
  const std::size_t first = line.find(' '), second = line.rfind(' ');
  if (first == std::string::npos || first == second || !line.substr(second + 1).starts_with("HTTP/1."))
    return answer("400 Bad Request", "expected GET /metrics HTTP/1.1\n");
  const std::string method = line.substr(0, first), target = line.substr(first + 1, second - first - 1);
  if (method != "GET") return answer("405 Method Not Allowed", "only GET\n", "Allow: GET\r\n");
  if (target.substr(0, target.find('?')) != "/metrics") return answer("404 Not Found", "there is only /metrics\n");
  return answer("200 OK", text());
}

struct MetricsPort::Visitor {
  int descriptor = -1;
  EventLoop::Id watch = 0;
  std::string request;
  OutputBuffer output;
  bool answered = false;
  int seconds = 0;
  ~Visitor() { ::close(descriptor); }
};

MetricsPort::MetricsPort(EventLoop& loop, Listener listener, std::function<std::string()> text, Log& log)
    : loop_(loop), listener_(std::move(listener)), text_(std::move(text)), log_(log) {}

Result<std::unique_ptr<MetricsPort>> MetricsPort::open(EventLoop& loop, Listener listener,
                                                       std::function<std::string()> text, Log& log) {
  std::unique_ptr<MetricsPort> port(new MetricsPort(loop, std::move(listener), std::move(text), log));
  const auto watch = loop.watch(port->listener_.descriptor(), EventLoop::kReadable,
                                [self = port.get()](std::uint32_t) { self->accept_some(); });
  if (!watch) return watch.error();
  port->watch_ = *watch;
  const auto timer = loop.every(std::chrono::seconds(1), [self = port.get()] { self->look(); });
  if (!timer) return timer.error();
  port->timer_ = *timer;
  return port;
}

MetricsPort::~MetricsPort() {
  if (watch_ != 0) loop_.forget(watch_);
  if (timer_ != 0) loop_.forget(timer_);
  for (const auto& [descriptor, visitor] : visitors_) loop_.forget(visitor->watch);
}

void MetricsPort::accept_some() {
  for (std::size_t i = 0; i < kMostVisitors; ++i) {
    int descriptor = -1;
    const Listener::Got got = listener_.accept(descriptor);
    if (got == Listener::Got::nothing) return;
    if (got == Listener::Got::connection) {
      admit(descriptor);
      continue;
    }
    log_.limited("metrics descriptors", "metrics: no descriptor is left; raise the limit of open files (LimitNOFILE=)");
    paused_ = true;
    return loop_.change(watch_, 0);
  }
}

void MetricsPort::admit(int descriptor) {
  auto visitor = std::make_unique<Visitor>();
  visitor->descriptor = descriptor;
  if (visitors_.size() >= kMostVisitors) return;  // closed
  const auto watch =
      loop_.watch(descriptor, EventLoop::kReadable, [this, descriptor](std::uint32_t) { ready(descriptor); });
  if (!watch) return;
  visitor->watch = *watch;
  visitors_.emplace(descriptor, std::move(visitor));
}

// False: the other end is gone.
bool MetricsPort::read_some(Visitor& visitor) {
  std::array<char, kMostRequestBytes> bytes;  // NOLINT(cppcoreguidelines-pro-type-member-init): written by recv
  const ssize_t got = recv(visitor.descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (got < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
  if (got == 0) return visitor.answered;
  if (visitor.answered) return true;
  visitor.request.append(bytes.data(), static_cast<std::size_t>(got));
  const std::size_t end = visitor.request.find("\r\n\r\n");
  if (end == std::string::npos && visitor.request.size() < kMostRequestBytes) return true;
  visitor.answered = true;
  visitor.output.add(end == std::string::npos ? answer("400 Bad Request", "the request is too long\n")
                                              : http_answer(visitor.request.substr(0, end + 2), text_));
  return true;
}

void MetricsPort::ready(int descriptor) {
  const auto found = visitors_.find(descriptor);
  if (found == visitors_.end()) return;
  Visitor& visitor = *found->second;
  const bool here = read_some(visitor) && visitor.output.flush(descriptor);
  if (here && !(visitor.answered && visitor.output.pending() == 0))
    return loop_.change(visitor.watch, visitor.answered ? EventLoop::kWritable : EventLoop::kReadable);
  (void)shutdown(descriptor, SHUT_RDWR);
  loop_.forget(visitor.watch);
  visitors_.erase(found);
}

// Once a second.
void MetricsPort::look() {
  if (std::exchange(paused_, false)) loop_.change(watch_, EventLoop::kReadable);
  std::vector<int> late;
  for (const auto& [descriptor, visitor] : visitors_)
    if (++visitor->seconds > kMostSeconds) late.push_back(descriptor);
  for (const int descriptor : late) {
    loop_.forget(visitors_.at(descriptor)->watch);
    visitors_.erase(descriptor);
  }
}

}  // namespace onemap::daemon
