#include "control/socket_place.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "support/temp_folder.hpp"

namespace onemap::control {
namespace {

void make_socket(const std::string& path) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << path;
  close(fd);
}

TEST(SocketPlace, TheRuntimeDirectoryOfSystemdThenOfTheLoginThenOut) {
  EXPECT_EQ(default_socket({"/run/onemap", "/run/user/7", ""}, "r1", "/o"), "/run/onemap/control.sock");
  EXPECT_EQ(default_socket({"", "/run/user/7", ""}, "r1", "/o"), "/run/user/7/onemap/r1.sock");
  EXPECT_EQ(default_socket({"", "", ""}, "r1", "/o"), "/o/control.sock");
}

TEST(SocketPlace, ClientsFindWhatThereIs) {
  const test::TempFolder folder;
  for (const char* socket : {"run/control.sock", "run/b/control.sock", "user/onemap/r1.sock"})
    make_socket(folder / socket);
  folder.write("run/a/control.sock", "no socket");
  const Environment environment{"", folder / "user", ""};
  EXPECT_EQ(likely_sockets(environment, folder / "run"),
            (std::vector<std::string>{folder / "run/b/control.sock", folder / "run/control.sock",
                                      folder / "user/onemap/r1.sock"}));
  EXPECT_EQ(likely_sockets({folder / "run", "", ""}, folder / "none"),
            (std::vector<std::string>{folder / "run/control.sock"}));
  EXPECT_EQ(likely_sockets({"", "", "/x.sock"}, folder / "run"), (std::vector<std::string>{"/x.sock"}));
  EXPECT_TRUE(likely_sockets({}, folder / "none").empty());
}

TEST(SocketPlace, OfAListOfRuntimeDirectoriesTheFirst) {
  setenv("RUNTIME_DIRECTORY", "/run/a:/run/b", 1);
  EXPECT_EQ(environment().runtime_directory, "/run/a");
  unsetenv("RUNTIME_DIRECTORY");
}

}  // namespace
}  // namespace onemap::control
