// Robots that were told nothing of each other but a multicast group.
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "comms/udp/udp_port.hpp"
#include "support/running.hpp"
#include "support/temp_folder.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;

bool multicast_loops_back() {
  const comms::Endpoint group = comms::Endpoint::ipv4(239, 77, 1, 4, 7480);
  auto port = comms::UdpPort::open({comms::Endpoint::ipv4(127, 0, 0, 1, 0), group});
  comms::OutgoingDatagram out;
  out.to = group;
  out.size = 1;
  comms::IncomingDatagram in;
  return port.ok() && (*port)->send(out) && (*port)->wait(1s) && (*port)->receive(in);
}

TEST(Group, RobotsFindEachOtherInIt) {
  if (!multicast_loops_back()) GTEST_SKIP() << "no multicast on loopback here";
  const test::TempFolder folder;
  folder.write("net.toml", "[network]\nlisten = \"127.0.0.1:0\"\ngroup = \"239.77.1.5:" +
                               std::to_string(test::free_port()) + "\"\n");
  const std::string camera = "simulated:office?frames=20&robot=";
  const std::vector<std::string> config{"--speed", "max", "--config", folder / "net.toml"};
  test::Robot a(folder, "a", camera + "1&robots=2", config), b(folder, "b", camera + "2&robots=2", config);
  EXPECT_TRUE(a.says("neighbour b at 127.0.0.1:")) << a.log();
  EXPECT_TRUE(b.says("neighbour a at 127.0.0.1:")) << b.log();
  EXPECT_EQ(a.stop(), 0) << a.log();
  EXPECT_EQ(b.stop(), 0) << b.log();
}

}  // namespace
}  // namespace onemap
