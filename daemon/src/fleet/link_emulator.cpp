#include "daemon/fleet/link_emulator.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "daemon/clock.hpp"
#include "hal/base/splitmix.hpp"

namespace onemap::daemon {

namespace {
constexpr int kBufferBytes = 4 << 20;
constexpr int kLongestWait_ms = 50;
constexpr int kDatagramsAtOnce = 64;

const sockaddr* generic(const sockaddr_in& address) { return reinterpret_cast<const sockaddr*>(&address); }
sockaddr* generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }
}  // namespace

struct LinkEmulator::End {
  int socket = -1;
  std::uint16_t port = 0;
  bool known = false;  // its robot spoke
  sockaddr_in robot{};
  SplitMix random{0};
};

struct LinkEmulator::Late {
  Instant due{};
  std::uint64_t arrival = 0;
  std::size_t to = 0;  // end
  std::vector<std::uint8_t> bytes;
  static bool later(const Late& a, const Late& b) { return a.due != b.due ? a.due > b.due : a.arrival > b.arrival; }
};

LinkEmulator::LinkEmulator(const LinkFaults& faults) : faults_(faults) {}

Result<std::unique_ptr<LinkEmulator>> LinkEmulator::open(const std::vector<FleetLink>& links,
                                                         const LinkFaults& faults) {
  std::unique_ptr<LinkEmulator> emulator(new LinkEmulator(faults));
  emulator->links_ = links;
  SplitMix seeds(faults.seed);
  for (std::size_t i = 0; i < 2 * links.size(); ++i) {
    End end;
    const auto failed = [](const char* what) {
      return Error{"link emulator", std::string(what) + ": " + std::strerror(errno)};
    };
    end.socket = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (end.socket < 0) return failed("socket");
    emulator->ends_.push_back(end);  // from here on it is closed by the destructor
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (bind(end.socket, generic(address), sizeof address) != 0) return failed("bind to 127.0.0.1");
    socklen_t length = sizeof address;
    if (getsockname(end.socket, generic(address), &length) != 0) return failed("getsockname");
    setsockopt(end.socket, SOL_SOCKET, SO_RCVBUF, &kBufferBytes, sizeof kBufferBytes);
    emulator->ends_.back().port = ntohs(address.sin_port);
    emulator->ends_.back().random = SplitMix(seeds.next());
  }
  return emulator;
}

LinkEmulator::~LinkEmulator() {
  stop();
  for (const End& end : ends_) close(end.socket);
}

std::uint16_t LinkEmulator::port(std::size_t link, std::size_t robot) const {
  return ends_[2 * link + (links_[link].first == robot ? 0 : 1)].port;
}

void LinkEmulator::start() { thread_ = std::thread(&LinkEmulator::run, this); }

void LinkEmulator::stop() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void LinkEmulator::run() {
  std::vector<pollfd> polls;
  for (const End& end : ends_) polls.push_back({end.socket, POLLIN, 0});
  while (!stopping_) {
    int wait_ms = kLongestWait_ms;
    if (!late_.empty()) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(late_.front().due - now()).count();
      wait_ms = static_cast<int>(std::clamp<std::int64_t>(left, 0, kLongestWait_ms));
    }
    poll(polls.data(), polls.size(), wait_ms);
    for (std::size_t i = 0; i < polls.size(); ++i)
      if (polls[i].revents != 0) receive(i);
    deliver_due(now());
  }
}

void LinkEmulator::receive(std::size_t index) {
  std::array<std::uint8_t, 2048> buffer;
  End& end = ends_[index];
  for (int i = 0; i < kDatagramsAtOnce; ++i) {
    socklen_t length = sizeof end.robot;
    const ssize_t size = recvfrom(end.socket, buffer.data(), buffer.size(), 0, generic(end.robot), &length);
    if (size < 0) return;  // nothing waits, or the robot is gone
    end.known = true;
    if (end.random.unit() < faults_.loss) {
      ++lost_;
      continue;
    }
    late_.push_back({now() + faults_.delay, arrivals_++, index ^ 1, {buffer.begin(), buffer.begin() + size}});
    std::ranges::push_heap(late_, Late::later);
  }
}

void LinkEmulator::deliver_due(Instant now) {
  while (!late_.empty() && late_.front().due <= now) {
    std::ranges::pop_heap(late_, Late::later);
    forward(late_.back());
    late_.pop_back();
  }
}

void LinkEmulator::forward(const Late& datagram) {
  const End& end = ends_[datagram.to];
  if (end.known &&
      sendto(end.socket, datagram.bytes.data(), datagram.bytes.size(), 0, generic(end.robot), sizeof end.robot) >= 0)
    ++forwarded_;
  else
    ++without_receiver_;
}

}  // namespace onemap::daemon
