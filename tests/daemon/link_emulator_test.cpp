#include "daemon/fleet/link_emulator.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <optional>
#include <set>
#include <string>

#include "daemon/clock.hpp"

namespace onemap::daemon {
namespace {

// A robot's side: a plain UDP socket.
class Speaker {
 public:
  Speaker() : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    const sockaddr_in any = address(0);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&any), sizeof any), 0);
  }
  ~Speaker() { close(socket_); }
  Speaker(const Speaker&) = delete;
  Speaker& operator=(const Speaker&) = delete;
  void send(std::uint16_t port, const std::string& text) const {
    const sockaddr_in to = address(port);
    sendto(socket_, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  // The next datagram and the port that it came from.
  std::optional<std::pair<std::string, std::uint16_t>> hear(int timeout_ms) const {
    pollfd poll_for{socket_, POLLIN, 0};
    if (poll(&poll_for, 1, timeout_ms) <= 0) return std::nullopt;
    std::string text(2048, 0);
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t size = recvfrom(socket_, text.data(), text.size(), 0, reinterpret_cast<sockaddr*>(&from), &length);
    text.resize(static_cast<std::size_t>(size));
    return std::pair{text, ntohs(from.sin_port)};
  }

 private:
  static sockaddr_in address(std::uint16_t port) {
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    a.sin_port = htons(port);
    return a;
  }
  int socket_;
};

std::unique_ptr<LinkEmulator> line_of_three(const LinkFaults& faults) {
  auto emulator = LinkEmulator::open({{0, 1}, {1, 2}}, faults);
  EXPECT_TRUE(emulator.ok());
  (*emulator)->start();
  return std::move(*emulator);
}

TEST(LinkEmulator, CarriesBothWaysAndOnlyBetweenLinkedRobots) {
  auto links = line_of_three({});
  const Speaker one, two, three;
  // Everybody speaks once on each of its links, so that the ends know them; what comes too early may be lost.
  one.send(links->port(0, 0), "hello");
  three.send(links->port(1, 2), "hello");
  while (two.hear(100)) {
  }
  two.send(links->port(0, 1), "to one");
  const auto heard = one.hear(2000);
  ASSERT_TRUE(heard);
  EXPECT_EQ(heard->first, "to one");
  EXPECT_EQ(heard->second, links->port(0, 0)) << "a robot hears its neighbour from the end that it speaks to";
  EXPECT_FALSE(three.hear(100)) << "robot 3 is not on this link";
  one.send(links->port(0, 0), "to two");
  const auto answer = two.hear(2000);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->first, "to two");
  EXPECT_EQ(answer->second, links->port(0, 1));
}

// Sends 2000 numbered datagrams and returns the numbers that arrived.
std::set<int> survivors(const LinkFaults& faults) {
  auto links = line_of_three(faults);
  const Speaker one, two;
  one.send(links->port(0, 0), "-1");
  while (!one.hear(10)) two.send(links->port(0, 1), "here");  // until a greeting got through: both are known
  while (two.hear(20)) {
  }
  std::set<int> arrived;
  constexpr int kSent = 2000;
  for (int i = 0; i < kSent; ++i) {
    one.send(links->port(0, 0), std::to_string(i));
    while (const auto heard = two.hear(0)) arrived.insert(std::stoi(heard->first));
    if (i % 100 == 99) usleep(2000);
  }
  while (const auto heard = two.hear(200)) arrived.insert(std::stoi(heard->first));
  return arrived;
}

TEST(LinkEmulator, LosesThePartThatItIsToldTo) {
  const auto arrived = survivors({0.2, {}, 7});
  EXPECT_NEAR(static_cast<double>(arrived.size()) / 2000, 0.8, 0.04);  // 4.5 standard deviations
}

TEST(LinkEmulator, TheSeedDecidesWhichAreLost) {
  const auto first = survivors({0.2, {}, 7}), second = survivors({0.2, {}, 7}), other = survivors({0.2, {}, 8});
  EXPECT_EQ(first, second);
  EXPECT_NE(first, other);
}

TEST(LinkEmulator, DelaysAndKeepsTheOrder) {
  auto links = line_of_three({0, std::chrono::milliseconds(60), 1});
  const Speaker one, two;
  two.send(links->port(0, 1), "here");
  usleep(100000);
  const Instant sent = now();
  for (int i = 0; i < 10; ++i) one.send(links->port(0, 0), std::to_string(i));
  for (int i = 0; i < 10; ++i) {
    const auto heard = two.hear(2000);
    ASSERT_TRUE(heard);
    EXPECT_EQ(heard->first, std::to_string(i));
    if (i == 0) {
      EXPECT_GE(now() - sent, std::chrono::milliseconds(59));
    }
  }
}

}  // namespace
}  // namespace onemap::daemon
