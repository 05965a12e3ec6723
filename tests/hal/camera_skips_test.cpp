// What the tests of cameras do where something that they need is not there: they end with 77, which ctest and ./check
// take for a skip, and name it. A pass would be a lie.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "support/other_program.hpp"
#include "support/temp_folder.hpp"

namespace onemap {
namespace {

namespace fs = std::filesystem;
using test::Said;
using testing::HasSubstr;

const std::string kSource = ONEMAP_SOURCE_DIR, kBin = ONEMAP_BIN_DIR;

// A machine that .ci/camera-test finds all that it needs on, but that nothing of it does its work: the first piece that
// is hidden is what it must stumble over.
class Machine {
 public:
  Machine() {
    fs::create_directories(folder_.path() / "bin");
    for (const char* place : {"/usr/bin", "/bin"})
      for (const auto& tool : fs::directory_iterator(place))
        if (const fs::path link = bin(tool.path().filename()); !fs::is_symlink(link))
          fs::create_symlink(tool.path(), link);
    for (const char* file : {".ci/camera-test", ".ci/machine.sh", ".ci/packages.sh"}) {
      fs::create_directories((folder_.path() / "tree" / file).parent_path());
      fs::copy_file(fs::path(kSource) / file, folder_.path() / "tree" / file);
    }
    tool("uname", "echo x86_64");
    tool("qemu-system-x86_64", "echo it boots; exit 1");
    tool("apt-cache", "echo ' Depends: linux-image-6.1.0-1-amd64'");
    tool("apt-get", "shift 2; : >$1.deb");  // download -qq PACKAGE
    // --extract FILE FOLDER
    tool("dpkg-deb",
         "mkdir -p $3/bin $3/lib/modules/6/kernel; cd $3; : >bin/busybox; cd lib/modules/6/kernel; "
         ": >vhci-hcd.ko; : >uvcvideo.ko");
    tool("cmake", "exit 0");
    tool("ldd", "echo libfreenect.so.0 libusb-1.0.so.0");
  }
  void tool(const std::string& name, const std::string& script) {
    fs::remove(bin(name));
    folder_.write("bin/" + name, "#!/bin/sh\n" + script + "\n");
    fs::permissions(bin(name), fs::perms::owner_all);
  }
  void hide(const std::string& name) { fs::remove(bin(name)); }
  Said camera_test() const {
    const std::string path = folder_.path().string();
    return test::say("env -i PATH=" + path + "/bin " + path + "/bin/bash " + path + "/tree/.ci/camera-test --work " +
                     path + "/work");
  }

 private:
  fs::path bin(const fs::path& name) const { return folder_.path() / "bin" / name; }
  test::TempFolder folder_;
};

void expect_skip(const Said& said, const std::string& why) {
  EXPECT_EQ(said.status, 77) << said.output;
  EXPECT_THAT(said.output, HasSubstr("camera-test skipped: " + why));
}

TEST(CameraSkips, AToolThatIsMissingIsNamed) {
  for (const char* tool : {"qemu-system-x86_64", "dpkg-deb", "apt-get"}) {
    Machine machine;
    machine.hide(tool);
    expect_skip(machine.camera_test(), std::string(tool) + " is missing (Debian: qemu-system-x86 dpkg apt)");
  }
}

TEST(CameraSkips, AKernelThatIsMissingIsNamed) {
  Machine unknown;
  unknown.tool("apt-cache", "echo 'E: No packages found' >&2; exit 100");
  expect_skip(unknown.camera_test(), "apt knows no linux-image-amd64");
  Machine alone;
  alone.tool("apt-get", "echo 'E: no network' >&2; exit 100");
  expect_skip(alone.camera_test(), "linux-image-6.1.0-1-amd64 cannot be fetched: is there a network?");
  EXPECT_THAT(alone.camera_test().output, HasSubstr("E: no network"));
  Machine half;
  half.tool("apt-get", "shift 2; [ $1 != busybox-static ] && : >$1.deb");
  expect_skip(half.camera_test(), "busybox-static cannot be fetched");
}

TEST(CameraSkips, AKernelWithoutTheDriversIsNamed) {
  for (const std::string driver : {"vhci-hcd", "uvcvideo"}) {
    Machine machine;
    const std::string other = driver == "uvcvideo" ? "vhci-hcd" : "uvcvideo";
    machine.tool("dpkg-deb", "mkdir -p $3/bin $3/lib/modules/6/kernel; : >$3/bin/busybox; : >$3/lib/modules/6/kernel/" +
                                 other + ".ko");
    expect_skip(machine.camera_test(), "the kernel 6 has no " + driver);
  }
}

TEST(CameraSkips, ADaemonWithoutTheLibrariesIsNamed) {
  Machine machine;
  machine.tool("ldd", "echo libusb-1.0.so.0");
  expect_skip(machine.camera_test(), "onemapd was built without libfreenect (Debian: libfreenect-dev");
}

TEST(CameraSkips, AnotherProcessorIsNamed) {
  Machine machine;
  machine.tool("uname", "echo aarch64");
  expect_skip(machine.camera_test(), "the virtual machine is an x86_64, this machine is not");
}

// Nothing is missing: then it is no skip, whatever becomes of it.
TEST(CameraSkips, WithAllThatItNeedsItGoesOn) {
  const Said said = Machine().camera_test();
  EXPECT_THAT(said.output, HasSubstr("the machine's files"));
  EXPECT_NE(said.status, 77) << said.output;
  EXPECT_NE(said.status, 0);
}

TEST(CameraSkips, TestsOnPlayedDevicesOutsideUmockdevEndWith77) {
  for (const char* program : {"test_v4l2", "test_kinect_usb", "test_kinect_streams"}) {
    if (!fs::exists(kBin + "/" + program)) GTEST_SKIP() << program << " was not built: its own test says why";
    const Said said = test::say("env -u LD_PRELOAD " + kBin + "/" + program);
    EXPECT_EQ(said.status, 77) << said.output;
    EXPECT_THAT(said.output, HasSubstr("skipped: umockdev-wrapper is not around this program (Debian: umockdev)"));
  }
}

// The folders of those tests, as CMake configures them on a machine without the libraries, under ctest.
TEST(CameraSkips, TestsThatWereNotBuiltAreSkipsInCtest) {
  const test::TempFolder folder;
  folder.write("CMakeLists.txt",
               "cmake_minimum_required(VERSION 3.25)\nproject(skips NONE)\nenable_testing()\n"
               "include(" +
                   kSource +
                   "/tests/skipped_test.cmake)\n"
                   "macro(pkg_check_modules name)\n  set(${name}_FOUND OFF)\nendmacro()\n"
                   "macro(find_program name)\n  set(${name} ${name}-NOTFOUND)\nendmacro()\n"
                   "add_subdirectory(" +
                   kSource + "/tests/hal/v4l2 v4l2)\nadd_subdirectory(" + kSource + "/tests/kinect/usb usb)\n");
  const std::string at = folder.path().string();
  const Said configured = test::say("cmake -G Ninja -S " + at + " -B " + at + "/build");
  ASSERT_EQ(configured.status, 0) << configured.output;
  const Said tested = test::say("ctest -V --test-dir " + at + "/build");
  EXPECT_THAT(tested.output, HasSubstr("skipped: missing (Debian): libumockdev-dev umockdev\n"));
  EXPECT_THAT(tested.output, HasSubstr("skipped: missing (Debian): libfreenect-dev libumockdev-dev umockdev\n"));
  for (const char* name : {"V4l2UnderUmockdev", "KinectUnderUmockdev", "KinectStreamsUnderUmockdev"})
    EXPECT_THAT(tested.output, testing::ContainsRegex(std::string("[0-9] - ") + name + " \\(Skipped\\)"));
}

}  // namespace
}  // namespace onemap
