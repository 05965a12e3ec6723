#include "daemon/pose_streams.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "support/temp_folder.hpp"

namespace onemap::daemon {
namespace {

using test::TempFolder;
using testing::HasSubstr;

class Reader {
 public:
  explicit Reader(const std::string& path) : socket_(::socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, path.size());
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { ::close(socket_); }
  bool connected() const { return connected_; }
  std::string read() {
    char text[65536];
    const ssize_t n = ::recv(socket_, text, sizeof text, MSG_DONTWAIT);
    return n < 0 ? "nothing" : std::string(text, static_cast<std::size_t>(n));
  }

 private:
  int socket_;
  bool connected_ = false;
};

RecordedPose pose(int i, bool in_map = true) {
  RecordedPose pose{FrameTime(std::chrono::milliseconds(1000 + i)), {mapping::Matrix3d::Identity(), {1, 2, 3}}, {}};
  if (in_map) pose.T_map_odom = mapping::Pose{mapping::Matrix3d::Identity(), {10, 0, 0}};
  return pose;
}

TEST(PoseStreams, EachFrameIsALineOfATrajectoryInEachFrameOfReference) {
  const TempFolder folder;
  auto streams = PoseStreams::open(folder / "poses");
  ASSERT_TRUE(streams) << streams.error().text();
  streams->say(pose(0));
  Reader odom(folder / "poses.odom"), map(folder / "poses.map");
  streams->say(pose(1));
  streams->say(pose(2, false));
  EXPECT_EQ(odom.read(),
            "# time tx ty tz qx qy qz qw: T_odom_camera\n"
            "1.001000 1.000000000 2.000000000 3.000000000 0.000000000 0.000000000 0.000000000 1.000000000\n"
            "1.002000 1.000000000 2.000000000 3.000000000 0.000000000 0.000000000 0.000000000 1.000000000\n");
  EXPECT_EQ(map.read(),
            "# time tx ty tz qx qy qz qw: T_map_camera\n"
            "1.001000 11.000000000 2.000000000 3.000000000 0.000000000 0.000000000 0.000000000 1.000000000\n");
  EXPECT_EQ(streams->view().readers, 2u);
  EXPECT_EQ(streams->view().lines, 3u);
  EXPECT_EQ(streams->view().dropped, 0u);
}

TEST(PoseStreams, WhoDoesNotReadIsDroppedAndTheOthersHearOn) {
  const TempFolder folder;
  auto streams = PoseStreams::open(folder / "poses");
  ASSERT_TRUE(streams);
  Reader deaf(folder / "poses.odom"), good(folder / "poses.odom");
  {
    const Reader leaves(folder / "poses.odom");
    streams->say(pose(0));
    EXPECT_EQ(streams->view().readers, 3u);
  }
  for (int i = 1; i < 20000 && streams->view().dropped == 0; ++i) {
    streams->say(pose(i));
    good.read();
  }
  EXPECT_EQ(streams->view().dropped, 1u) << "who left was not dropped";
  EXPECT_EQ(streams->view().readers, 1u);
  streams->say(pose(20000));
  EXPECT_THAT(good.read(), HasSubstr("21.000000 "));
}

TEST(PoseStreams, MoreReadersThanThereIsRoomForAreTurnedAway) {
  const TempFolder folder;
  auto streams = PoseStreams::open(folder / "poses");
  ASSERT_TRUE(streams);
  std::vector<std::unique_ptr<Reader>> readers;
  for (std::size_t i = 0; i < PoseStreams::kReaders + 1; ++i) {
    readers.push_back(std::make_unique<Reader>(folder / "poses.map"));
    streams->say(pose(0));
  }
  EXPECT_EQ(streams->view().readers, PoseStreams::kReaders);
  EXPECT_EQ(streams->view().dropped, 1u);
  EXPECT_EQ(readers.back()->read(), "");
}

TEST(PoseStreams, SocketsOfADeadDaemonAreTakenAndOthersAreNot) {
  const TempFolder folder;
  {
    auto streams = PoseStreams::open(folder / "poses");
    ASSERT_TRUE(streams);
    EXPECT_THAT(PoseStreams::open(folder / "poses").error().text(), HasSubstr("Address already in use"));
  }
  EXPECT_EQ(folder.entries(), 0u) << "removed at the end";
  {
    // What a killed daemon leaves.
    const int left = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    (folder / "poses.odom").copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(left);
    EXPECT_TRUE(PoseStreams::open(folder / "poses"));
  }
  folder.write("poses.map", "a file");
  EXPECT_THAT(PoseStreams::open(folder / "poses").error().text(), HasSubstr("poses.map: cannot listen"));
  EXPECT_THAT(PoseStreams::open(folder / std::string(120, 'x')).error().text(), HasSubstr("longer than"));
}

}  // namespace
}  // namespace onemap::daemon
