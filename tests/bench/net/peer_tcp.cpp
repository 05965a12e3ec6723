// TCP with the kernel's congestion control of that name: bulk on one connection, poses on another.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <thread>

#include "peer.hpp"

namespace onemap::bench {

namespace {
constexpr std::uint16_t kBulkPort = 7448, kPosePort = 7449;

sockaddr_in at(const std::string& address, std::uint16_t port) {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  in.sin_port = htons(port);
  inet_pton(AF_INET, address.c_str(), &in.sin_addr);
  return in;
}

// False: the kernel has no such congestion control, and would go on with its own.
bool choose(int s, const Job& job) {
  return setsockopt(s, IPPROTO_TCP, TCP_CONGESTION, job.flavour.c_str(), static_cast<socklen_t>(job.flavour.size())) ==
         0;
}

bool is_here(const Job& job) {
  const int s = socket(AF_INET, SOCK_STREAM, 0);
  const bool chosen = choose(s, job);
  close(s);
  return chosen;
}

int connect_to(const Job& job, std::uint16_t port) {
  const sockaddr_in there = at(job.there, port);
  for (int i = 0; i < 200; ++i) {
    const int s = socket(AF_INET, SOCK_STREAM, 0);
    const int on = 1;
    choose(s, job);
    setsockopt(s, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (connect(s, reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0) return s;
    close(s);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return -1;
}

int listen_at(const Job& job, std::uint16_t port) {
  const int s = socket(AF_INET, SOCK_STREAM, 0);
  const int on = 1;
  setsockopt(s, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  const sockaddr_in here = at(job.here, port);
  if (bind(s, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0 || listen(s, 1) != 0) return -1;
  return s;
}

int send(const Job& job) {
  const int bulk = connect_to(job, kBulkPort), pose = job.poses ? connect_to(job, kPosePort) : -1;
  if (bulk < 0 || (job.poses && pose < 0)) return 1;
  const std::vector<std::uint8_t> body(kBulkBytes, 7);
  std::thread writer([&] {
    while (::send(bulk, body.data(), body.size(), MSG_NOSIGNAL) > 0) {
    }
  });
  PoseClock poses(job);
  while (job.poses) {
    std::this_thread::sleep_until(poses.next());
    if (!poses.due()) continue;
    const auto bytes = pose_now();
    if (::send(pose, bytes.data(), bytes.size(), MSG_NOSIGNAL) <= 0) break;
  }
  writer.join();
  return 0;
}

int receive(const Job& job) {
  std::array<int, 2> listeners{listen_at(job, kBulkPort), listen_at(job, kPosePort)};
  if (listeners[0] < 0 || listeners[1] < 0) return 1;
  std::array<pollfd, 4> polls{{{listeners[0], POLLIN, 0}, {listeners[1], POLLIN, 0}, {-1, POLLIN, 0}, {-1, POLLIN, 0}}};
  Tally tally(job.seconds);
  std::vector<std::uint8_t> buffer(1 << 18), pending;
  while (!tally.over()) {
    poll(polls.data(), polls.size(), 20);
    for (std::size_t i = 0; i < 2; ++i)
      if ((polls[i].revents & POLLIN) != 0) {
        polls[2 + i].fd = accept(polls[i].fd, nullptr, nullptr);
        polls[i].fd = -1;
      }
    if ((polls[2].revents & POLLIN) != 0)
      if (const ssize_t n = recv(polls[2].fd, buffer.data(), buffer.size(), 0); n > 0)
        tally.bulk(static_cast<std::size_t>(n));
    if ((polls[3].revents & POLLIN) == 0) continue;
    const ssize_t n = recv(polls[3].fd, buffer.data(), buffer.size(), 0);
    if (n > 0) pending.insert(pending.end(), buffer.begin(), buffer.begin() + n);
    for (; pending.size() >= kPoseBytes; pending.erase(pending.begin(), pending.begin() + kPoseBytes))
      tally.pose(std::span(pending).first(kPoseBytes));
  }
  tally.print(0.0);
  return 0;
}
}  // namespace

int run_tcp(const Job& job) {
  if (!is_here(job)) return 77;
  return job.sends ? send(job) : receive(job);
}

}  // namespace onemap::bench
