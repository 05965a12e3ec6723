#include "support/emulated_net.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>

namespace onemap::test {
namespace {
using namespace std::chrono_literals;

sockaddr_in at(const std::string& address, std::uint16_t port) {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  in.sin_port = htons(port);
  inet_pton(AF_INET, address.c_str(), &in.sin_addr);
  return in;
}
const sockaddr* generic(const sockaddr_in& in) { return reinterpret_cast<const sockaddr*>(&in); }

struct Got {
  int datagrams = 0;
  Duration time{};
};

// Sends so many datagrams of 972 bytes (1000 as packets) from one end of link 0 to the other and waits for them.
Got send_over(EmulatedNet& net, int datagrams, Duration patience) {
  int sender = -1, receiver = -1;
  net.in(0, [&] { sender = socket(AF_INET, SOCK_DGRAM, 0); });
  net.in(1, [&] {
    receiver = socket(AF_INET, SOCK_DGRAM, 0);
    const sockaddr_in here = at(net.address(0, 1), 5000);
    ASSERT_EQ(bind(receiver, generic(here), sizeof here), 0);
  });
  const sockaddr_in there = at(net.address(0, 1), 5000);
  std::array<char, 972> bytes{};
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < datagrams; ++i)
    EXPECT_EQ(sendto(sender, bytes.data(), bytes.size(), 0, generic(there), sizeof there), 972);
  Got got;
  pollfd wait{receiver, POLLIN, 0};
  const int patience_ms = static_cast<int>(patience / 1ms);
  while (got.datagrams < datagrams && poll(&wait, 1, patience_ms) > 0 &&
         recv(receiver, bytes.data(), bytes.size(), 0) == 972) {
    ++got.datagrams;
    got.time = std::chrono::steady_clock::now() - began;
  }
  close(sender);
  close(receiver);
  return got;
}

TEST(EmulatedNet, PacketsTakeTheirTimeAndSomeAreLost) {
  LinkTraits traits;
  traits.bits_per_second = 4e6;
  traits.delay = 20ms;
  auto net = EmulatedNet::open(2, {{0, 1, traits, traits}}, 1);
  if (!net) GTEST_SKIP() << net.error().text();
  const Got one = send_over(**net, 1, 10s);
  EXPECT_EQ(one.datagrams, 1);
  EXPECT_GE(one.time, 22ms) << "2 ms on the air and 20 ms of delay";
  const Got many = send_over(**net, 100, 10s);
  EXPECT_EQ(many.datagrams, 100);
  EXPECT_GE(many.time, 219ms);
  LinkTraits lossy = traits;
  lossy.loss = 0.5;
  (*net)->set(0, lossy, traits);
  const Got some = send_over(**net, 200, 500ms);
  EXPECT_GT(some.datagrams, 50);
  EXPECT_LT(some.datagrams, 150);
  EXPECT_EQ((*net)->count(0).lost, static_cast<std::uint64_t>(200 - some.datagrams));
  (*net)->set_up(0, false);
  EXPECT_EQ(send_over(**net, 5, 100ms).datagrams, 0);
}

TEST(EmulatedNet, ProgramsRunInANamespace) {
  auto net = EmulatedNet::open(1, {}, 1);
  if (!net) GTEST_SKIP() << net.error().text();
  std::array<int, 2> pipe_ends{};
  ASSERT_EQ(pipe(pipe_ends.data()), 0);
  const pid_t child = (*net)->start(0, {"cat", "/proc/net/dev"}, pipe_ends[1]);
  ASSERT_GT(child, 0);
  close(pipe_ends[1]);
  std::string text;
  std::array<char, 4096> buffer;
  for (ssize_t n; (n = read(pipe_ends[0], buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(n));
  close(pipe_ends[0]);
  int status = -1;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_NE(text.find("lo:"), std::string::npos) << text;
  EXPECT_EQ(text.find("eth0:"), std::string::npos) << "another network than ours: " << text;
}

}  // namespace
}  // namespace onemap::test
