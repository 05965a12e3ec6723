#include "control/doctor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "control/doctor_alone.hpp"
#include "support/temp_folder.hpp"

namespace onemap::control {
namespace {

using testing::HasSubstr;

constexpr uid_t kDaemon = 4711;
constexpr gid_t kVideo = 4712;

// A machine in a folder; all that is in it belongs to whoever runs the test.
class Doctor : public testing::Test {
 protected:
  Doctor() {
    machine_ = {folder_.path().string(), getuid() == 0 ? 1 : getuid(), {}, [this](const std::string& option) {
                  return option == "--check-config" ? check_ : std::optional(option == "--dump-config" ? dump_ : list_);
                }};
    machine_.groups = {getgid()};
    std::filesystem::create_directories(folder_.path() / "out");
    dump("auto");
  }
  void dump(const std::string& camera, const std::string& key = "") {
    dump_.text = "[robot]\nid = \"r\"  # from default\ncamera = \"" + camera +
                 "\"  # from default\nout = \"/out\"  # from command line\n[team]\nkey_file = \"" + key +
                 "\"  # from default\n";
  }
  void file(const std::string& name, mode_t mode) {
    folder_.write(name.substr(1), "x\n");
    ASSERT_EQ(chmod((folder_.path().string() + name).c_str(), mode), 0);
  }
  void usb(const char* port, const char* vendor, const char* product, const char* devnum) {
    const std::string at = std::string("sys/bus/usb/devices/") + port + "/";
    for (const auto& [name, text] : {std::pair{"idVendor", vendor}, {"idProduct", product}, {"busnum", "1"}})
      folder_.write(at + name, std::string(text) + "\n");
    folder_.write(at + "devnum", std::string(devnum) + "\n");
  }
  // Of these that are about it.
  std::vector<Json> about(const std::string& what) {
    std::vector<Json> found;
    for (Json& finding : findings_without_daemon({"s.sock", "nobody listens"}, machine_))
      if (finding.value("about", "") == what) found.push_back(std::move(finding));
    return found;
  }
  void expect_good(const std::string& what, const std::string& text) {
    const auto found = about(what);
    ASSERT_EQ(found.size(), 1u) << what;
    EXPECT_TRUE(found[0].value("ok", false)) << found[0].dump();
    EXPECT_THAT(found[0].value("text", ""), HasSubstr(text));
  }
  void expect_bad(const std::string& what, const std::string& text, const std::string& advice) {
    const auto found = about(what);
    ASSERT_EQ(found.size(), 1u) << what;
    EXPECT_FALSE(found[0].value("ok", true)) << found[0].dump();
    EXPECT_THAT(found[0].value("text", ""), HasSubstr(text));
    EXPECT_THAT(found[0].value("advice", ""), HasSubstr(advice));
  }

  const test::TempFolder folder_;
  std::optional<Told> check_ = Told{0, "the configuration is good\n"};
  Told dump_, list_;
  Machine machine_;
};

TEST_F(Doctor, SaysThatNoDaemonAnswersAndHowToStartOne) {
  expect_bad("daemon", "s.sock: nobody listens", "systemctl start onemapd");
}

TEST_F(Doctor, AWrongConfigurationIsSaidAsTheDaemonSaysIt) {
  expect_good("config", "good");
  check_ = Told{2, "onemapd: /etc/onemap/onemap.toml:2: unknown key 'sped' in [run]\n"};
  expect_bad("config", "onemap.toml:2: unknown key 'sped' in [run]", "change the line");
  check_ = std::nullopt;
  expect_bad("config", "onemapd is not found", "PATH");
}

TEST_F(Doctor, NodesOfCamerasThatTheDaemonMayNotOpen) {
  machine_.user = kDaemon;
  machine_.groups = {kVideo};
  expect_bad("camera", "there is no /dev/video*", "onemapd --cameras");
  file("/dev/video0", 0660);
  expect_bad("camera", "/dev/video0: uid 4711 may not open it (mode 0660", "udevadm trigger");
  machine_.groups.push_back(getgid());
  expect_good("camera", "/dev/video0 can be opened");
  file("/dev/video0", 0640);
  expect_bad("camera", "mode 0640", "usermod -aG video");
  file("/dev/video0", 0666);
  expect_good("camera", "/dev/video0");
  machine_.groups = {kVideo};
  file("/dev/video0", 0606);
  expect_good("camera", "/dev/video0");
  usb("1-2", "046d", "c52b", "7");
  file("/dev/bus/usb/001/007", 0600);
  expect_good("camera", "/dev/video0 can be opened");  // a mouse is no camera
  usb("1-3", "045e", "02ae", "12");
  file("/dev/bus/usb/001/012", 0664);
  const auto found = about("camera");
  ASSERT_EQ(found.size(), 2u);
  EXPECT_THAT(found[0].value("text", ""), HasSubstr("/dev/bus/usb/001/012: uid 4711 may not open it"));
  dump("replay:/recordings/1");
  EXPECT_TRUE(about("camera").empty()) << "a recording needs none";
}

TEST_F(Doctor, ACameraThatDoesLessThanItCouldIsSaid) {
  machine_.user = getuid();
  file("/dev/video0", 0600);
  list_.text = R"({"found":[{"address":"v4l2:/dev/video0","limits":"is on USB 2"},{"address":"v4l2:/dev/video4"}]})";
  const auto found = about("camera");
  ASSERT_EQ(found.size(), 2u);
  EXPECT_FALSE(found[1].value("ok", true));
  EXPECT_EQ(found[1].value("text", ""), "v4l2:/dev/video0 is on USB 2");
  EXPECT_THAT(found[1].value("advice", ""), HasSubstr("port"));
  list_.status = 1;
  EXPECT_EQ(about("camera").size(), 1u) << "the list is not known";
}

TEST_F(Doctor, TheFilesOfKeysAreTheDaemonsAlone) {
  machine_.user = getuid();
  EXPECT_TRUE(about("team key").empty());
  file("/etc/onemap/team.key", 0600);
  expect_good("team key", "/etc/onemap/team.key");
  file("/etc/onemap/team.key", 0640);
  expect_bad("team key", "others may use it (mode 0640)", "chmod 600 /etc/onemap/team.key");
  dump("auto", "none");
  EXPECT_TRUE(about("team key").empty()) << "no key is wanted";
  dump("auto", "/k/mine.key");
  expect_bad("team key", "team.key_file is /k/mine.key: No such file", "onemapctl team join");
  file("/k/mine.key", 0604);
  expect_bad("team key", "/k/mine.key", "chmod 600 /k/mine.key");
  file("/out/identity", 0600);
  expect_good("identity", "/out/identity");
  machine_.user = kDaemon;
  expect_bad("identity", "and the daemon is 4711", "chown 4711 /out/identity");
}

TEST_F(Doctor, TheFolderThatCannotBeWrittenTo) {
  machine_.user = kDaemon;
  ASSERT_EQ(chmod((folder_ / "out").c_str(), 0755), 0);
  expect_bad("out folder", "uid 4711 may not write to /out (mode 0755", "chown -R 4711 /out");
  ASSERT_EQ(chmod((folder_ / "out").c_str(), 0777), 0);
  expect_good("out folder", "/out can be written to");
  std::filesystem::remove(folder_ / "out");
  expect_good("out folder", "the daemon makes it");
  file("/out", 0666);
  expect_bad("out folder", "/out is no folder", "robot.out");
}

TEST_F(Doctor, ASocketThatIsGoneAndAFolderThatEverybodyMayChange) {
  const std::string socket = folder_ / "open/c.sock";
  const auto finding = [&] { return own_findings(socket).at(0); };
  EXPECT_FALSE(finding().value("ok", true));
  EXPECT_THAT(finding().value("text", ""), HasSubstr("No such file"));
  folder_.write("open/c.sock", "");
  ASSERT_EQ(chmod((folder_ / "open").c_str(), 0755), 0);
  EXPECT_TRUE(finding().value("ok", false)) << finding().dump();
  ASSERT_EQ(chmod((folder_ / "open").c_str(), 0777), 0);
  EXPECT_FALSE(finding().value("ok", true));
  EXPECT_EQ(finding().value("advice", ""), "chmod o-w " + (folder_ / "open"));
  ASSERT_EQ(chmod((folder_ / "open").c_str(), 01777), 0);
  EXPECT_TRUE(finding().value("ok", false)) << "who owns it alone removes it";
  EXPECT_TRUE(own_findings(socket).at(1).value("ok", false)) << "no clock keeps a daemon from working";
}

}  // namespace
}  // namespace onemap::control
