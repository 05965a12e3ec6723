// The contract of all cameras through the kernel's uvcvideo and through libfreenect on the kernel's usbfs. Runs in the
// virtual machine of .ci/camera-test, where USB cameras that are programs are plugged into a virtual host controller.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <functional>
#include <stdexcept>

#include "hal/backends/libusb.hpp"
#include "hal/backends/v4l2.hpp"
#include "hal/camera_contract.hpp"

namespace onemap::hal {
namespace {

using Pairs = std::vector<std::pair<std::string, std::string>>;

void await(const std::string& what, const std::function<bool()>& there) {
  for (int tries = 0; !there(); ++tries) {
    if (tries == 400) throw std::runtime_error("waited in vain until " + what);
    usleep(50'000);
  }
}

// A virtual-camera at a port of the virtual host controller.
class Plugged {
 public:
  Plugged(std::string kind, int port, std::string film)
      : kind_(std::move(kind)), port_(std::to_string(port)), film_(std::move(film)) {}
  ~Plugged() { pull(); }
  Plugged(const Plugged&) = delete;
  Plugged& operator=(const Plugged&) = delete;

  void plug() {
    pid_ = fork();
    if (pid_ != 0) return;
    const int log = ::open(fmt::format("/tmp/camera{}.log", port_).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    execl("/bin/virtual-camera", "virtual-camera", kind_.c_str(), film_.c_str(), "again", port_.c_str(), nullptr);
    _exit(127);
  }
  // The kernel sees its socket close, also where it is paused.
  void pull() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  void pause(bool paused) const { kill(pid_, paused ? SIGSTOP : SIGCONT); }

 private:
  const std::string kind_, port_, film_;
  pid_t pid_ = -1;
};

// Two cameras of a kind, of which the first is paused and pulled out.
class TwoPlugged {
 public:
  static constexpr bool kLive = true;
  explicit TwoPlugged(const std::string& kind)
      : one_(kind, 0, "/" + kind + ".film"), other_(kind, 1, "/" + kind + "-other.film") {}
  std::string missing() const { return ""; }
  void plug() { one_.plug(); }
  void unplug() { one_.pull(); }
  void pause() { one_.pause(true); }
  void resume() { one_.pause(false); }

 protected:
  Plugged one_, other_;
};

class UvcRig : public TwoPlugged {
 public:
  UvcRig() : TwoPlugged("uvc") {
    one_.plug();
    await("the first camera is listed", [&] { return seen({}, node_); });
    other_.plug();
    await("the other camera is listed", [&] { return seen(node_, other_node_); });
  }
  ~UvcRig() {
    one_.pull();
    other_.pull();
    await("both cameras are gone", [] { return list_v4l2().empty(); });
  }
  auto open(const std::string& address, Duration clock_offset = {}) const {
    return open_text(open_v4l2, address, clock_offset);
  }
  std::string address() const { return node_ + "?calibration=/tmp/calibration.txt"; }
  std::string other() const { return other_node_ + "?calibration=/tmp/calibration.txt"; }
  Pairs wrong_addresses() const {
    return {{"v4l2:/dev/video99", "cannot be opened"},
            {node_, "the driver gives Z16 320x240"},
            {address() + "&fps=5", "the driver gives 30.0"},
            {address() + "&color=" + other_node_.substr(5), "it has Z16"}};
  }
  Pairs formats() const {
    return {{address(), "Z16 320x240, colour"}, {node_ + "?calibration=/tmp/two-lenses.txt", "two-lenses.txt"}};
  }

 private:
  // A depth node with a colour node beside it, that is not the other camera's.
  static bool seen(const std::string& but, std::string& node) {
    const auto all = list_v4l2();
    const auto found = std::ranges::find_if(all, [&](const CameraInfo& camera) {
      return camera.address != but && camera.problem.find("no colour node") == std::string::npos &&
             camera.abilities.find("colour") != std::string::npos;
    });
    if (found != all.end()) node = found->address;
    return found != all.end();
  }
  std::string node_, other_node_;
};
INSTANTIATE_TYPED_TEST_SUITE_P(Uvcvideo, CameraContract, UvcRig);

class FreenectRig : public TwoPlugged {
 public:
  FreenectRig() : TwoPlugged("kinect") {
    one_.plug();
    other_.plug();
    await("both Kinects are listed", [] { return listed() == 2; });
  }
  ~FreenectRig() {
    one_.pull();
    other_.pull();
    await("both Kinects are gone", [] { return listed() == 0; });
  }
  auto open(const std::string& address, Duration clock_offset = {}) const {
    return open_text(open_libusb, address, clock_offset);
  }
  std::string address() const { return "libusb:KINECT00"; }
  std::string other() const { return "libusb:KINECT01"; }
  Pairs wrong_addresses() const { return {{"libusb:KINECT09", "no Kinect with this serial number"}}; }
  Pairs formats() const {
    return {{address(), "registered by the device"}, {address() + "?registration=ours", "registered by us"}};
  }

 private:
  static std::size_t listed() { return list_libusb().size(); }
};
INSTANTIATE_TYPED_TEST_SUITE_P(Freenect, CameraContract, FreenectRig);

}  // namespace
}  // namespace onemap::hal
