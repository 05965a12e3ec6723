#include "daemon/addresses.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "comms/udp/udp_port.hpp"

namespace onemap::daemon {
namespace {

using testing::HasSubstr;

std::string why(const Status& status) { return status ? "" : status.error().text(); }

OwnNetwork network() {
  return {{comms::Endpoint::ipv4(10, 0, 0, 1, 0), comms::Endpoint::ipv4(127, 0, 0, 1, 0)},
          {comms::Endpoint::ipv4(10, 0, 0, 255, 0)}};
}

std::string refused(const std::string& listen, const std::vector<std::string>& peers) {
  return why(check_addresses(listen, peers, "", network()));
}

TEST(Addresses, APeerIsOneHost) {
  for (const char* good : {"10.0.0.2:4600", "127.0.0.1:1", "[fd00::2]:4600", "[::1]:1", "[::ffff:10.0.0.2]:4600"})
    EXPECT_EQ(why(check_peer(good)), "") << good;
  const std::pair<const char*, const char*> wrong[] = {{"10.0.0.2:0", "has port 0"},
                                                       {"[fd00::2]:0", "has port 0"},
                                                       {"0.0.0.0:4600", "is no host's address"},
                                                       {"[::]:4600", "is no host's address"},
                                                       {"0.1.2.3:4600", "reserved"},
                                                       {"224.0.0.1:4600", "multicast"},
                                                       {"239.255.255.255:4600", "multicast"},
                                                       {"240.0.0.1:4600", "reserved"},
                                                       {"255.255.255.255:4600", "broadcast"},
                                                       {"[ff02::1]:4600", "multicast"},
                                                       {"[fe80::1]:4600", "needs a zone"},
                                                       {"robot2:4600", "is not a numeric IPv4 address"},
                                                       {"10.0.0.2:65536", "port"},
                                                       {"", "no port"}};
  for (const auto& [peer, reason] : wrong) EXPECT_THAT(why(check_peer(peer)), HasSubstr(reason)) << peer;
}

TEST(Addresses, ARobotListensAtOneAddressOrAtAny) {
  for (const char* good : {"0.0.0.0:0", "0.0.0.0:4600", "[::]:4600", "10.0.0.1:4600", "127.0.0.1:0"})
    EXPECT_EQ(why(check_listen(good)), "") << good;
  for (const char* wrong : {"224.0.0.1:4600", "255.255.255.255:1", "[ff02::1]:1", "[fe80::1]:1", "4600", "x:1"})
    EXPECT_NE(why(check_listen(wrong)), "") << wrong;
}

TEST(Addresses, PeersAreOfAFamilyThatTheSocketReaches) {
  EXPECT_EQ(refused("0.0.0.0:4600", {"10.0.0.2:4600"}), "");
  EXPECT_EQ(refused("[::]:4600", {"10.0.0.2:4600", "[fd00::2]:4600"}), "");
  EXPECT_EQ(refused("[fd00::1]:4600", {"[fd00::2]:4600"}), "");
  EXPECT_THAT(refused("0.0.0.0:4600", {"[fd00::2]:4600"}),
              AllOf(HasSubstr("network.peers: \"[fd00::2]:4600\""), HasSubstr("speaks only IPv4")));
  EXPECT_THAT(refused("", {"[fd00::2]:4600"}), HasSubstr("speaks only IPv4"));
  EXPECT_THAT(refused("[fd00::1]:4600", {"10.0.0.2:4600"}), HasSubstr("speaks only IPv6"));
}

TEST(Addresses, AGroupIsMulticastOverIPv4) {
  for (const char* good : {"", "239.77.1.1:4600", "224.0.0.1:1"}) EXPECT_EQ(why(check_group(good)), "") << good;
  const std::pair<const char*, const char*> wrong[] = {{"239.77.1.1:0", "has port 0"},
                                                       {"10.0.0.2:4600", "is no IPv4 multicast address"},
                                                       {"240.0.0.1:4600", "is no IPv4 multicast address"},
                                                       {"[ff02::1]:4600", "is no IPv4 multicast address"},
                                                       {"239.77.1.1", "239.77.1.1"}};
  for (const auto& [group, reason] : wrong) EXPECT_THAT(why(check_group(group)), HasSubstr(reason)) << group;
  const auto with = [](const char* listen, const char* group) {
    return why(check_addresses(listen, {}, group, network()));
  };
  EXPECT_EQ(with("", "239.77.1.1:4600"), "");
  EXPECT_EQ(with("10.0.0.1:4600", "239.77.1.1:4600"), "");
  EXPECT_THAT(with("[::]:4600", "239.77.1.1:4600"),
              HasSubstr("network.group: \"239.77.1.1:4600\" needs an IPv4 socket"));
  EXPECT_THAT(with("", "10.0.0.2:4600"), HasSubstr("network.group"));
}

// That this is what sockets do.
TEST(Addresses, SocketsReachWhatIsSaidOfThem) {
  const auto reaches = [](const char* listen, const char* peer) {
    auto port = comms::UdpPort::open({*comms::parse_endpoint(listen), {}});
    if (!port) return std::string("no socket: ") + port.error().text();
    comms::OutgoingDatagram datagram;
    datagram.to = *comms::parse_endpoint(peer);
    datagram.size = 1;
    return std::string((*port)->send(datagram) ? "yes" : "no");
  };
  EXPECT_EQ(reaches("0.0.0.0:0", "127.0.0.1:9"), "yes");
  EXPECT_EQ(reaches("0.0.0.0:0", "[::1]:9"), "no");
  EXPECT_EQ(reaches("127.0.0.1:0", "127.0.0.1:0"), "no");
  const std::string both = reaches("[::]:0", "127.0.0.1:9");
  if (both.starts_with("no socket")) GTEST_SKIP() << "no IPv6 here: " << both;
  EXPECT_EQ(both, "yes");
  EXPECT_EQ(reaches("[::1]:0", "127.0.0.1:9"), "no");
}

TEST(Addresses, APeerIsNamedOnceAndIsSomebodyElse) {
  EXPECT_THAT(refused("0.0.0.0:4600", {"10.0.0.2:4600", "10.0.0.3:4600", "10.0.0.2:4600"}),
              HasSubstr("\"10.0.0.2:4600\" is given twice"));
  EXPECT_THAT(refused("0.0.0.0:4600", {"10.0.0.2:4600", "[::ffff:10.0.0.2]:4600"}), HasSubstr("is given twice"));
  EXPECT_EQ(refused("0.0.0.0:4600", {"10.0.0.2:4600", "10.0.0.2:4601"}), "");
  EXPECT_THAT(refused("10.0.0.1:4600", {"10.0.0.1:4600"}), HasSubstr("is this robot itself"));
  EXPECT_THAT(refused("0.0.0.0:4600", {"127.0.0.1:4600"}), HasSubstr("is this robot itself"));
  EXPECT_THAT(refused("0.0.0.0:4600", {"127.0.0.2:4600"}), HasSubstr("is this robot itself"));
  EXPECT_THAT(refused("0.0.0.0:4600", {"10.0.0.1:4600"}), HasSubstr("is this robot itself"));
  EXPECT_THAT(refused("[::]:4600", {"[::1]:4600"}), HasSubstr("is this robot itself"));
  EXPECT_EQ(refused("0.0.0.0:4600", {"10.0.0.1:4601"}), "") << "another robot on this machine";
  EXPECT_EQ(refused("127.0.0.1:4600", {"127.0.0.2:4600"}), "");
  EXPECT_EQ(refused("0.0.0.0:0", {"127.0.0.1:4600"}), "");
  EXPECT_THAT(refused("0.0.0.0:4600", {"10.0.0.255:4600"}), HasSubstr("is a broadcast address"));
}

TEST(Addresses, ThisMachineHasLoopback) {
  EXPECT_THAT(own_network().addresses, testing::Contains(comms::Endpoint::ipv4(127, 0, 0, 1, 0)));
}

}  // namespace
}  // namespace onemap::daemon
