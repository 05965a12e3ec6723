#pragma once
// Daemons that run while a test does something to them.
#include <unistd.h>

#include <chrono>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "comms/udp/udp_port.hpp"
#include "support/patience.hpp"
#include "support/program.hpp"

namespace onemap::test {

inline bool wait_until(const std::function<bool()>& done, std::chrono::milliseconds limit) {
  const auto end = std::chrono::steady_clock::now() + kPatience * limit;
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

// A free port of loopback, for a moment at least. Below the ports that the system gives out by itself, and from another
// one on in each process: what two tests that run at once ask for is not the same.
inline std::uint16_t free_port() {
  static auto next = static_cast<std::uint16_t>(20000 + getpid() * 37 % 12000);
  for (int tries = 0; tries < 100; ++tries) {
    const std::uint16_t port = next++;
    if (comms::UdpPort::open({comms::Endpoint::ipv4(127, 0, 0, 1, port), {}})) return port;
  }
  throw std::runtime_error("no free port from 20000 on");
}

inline std::string at(std::uint16_t port) { return "127.0.0.1:" + std::to_string(port); }

// One onemapd with a folder of its own below the test's.
class Robot {
 public:
  Robot(const TempFolder& folder, const std::string& name, const std::string& camera,
        const std::vector<std::string>& more, const std::string& id = {})
      : out_(folder / name), log_(folder / (name + ".log")) {
    std::vector<std::string> arguments{"--camera", camera, "--id", id.empty() ? name : id, "--out", out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    process_.emplace(start("onemapd", arguments, log_));
  }
  daemon::ChildProcess& process() { return *process_; }
  const std::filesystem::path& out() const { return out_; }
  std::string log() const { return text_of(log_); }
  nlohmann::json status() const { return nlohmann::json::parse(text_of(out_ / "status.json"), nullptr, false); }
  template <class T>
  T status(const char* key, T otherwise) const {
    const auto json = status();
    return json.is_object() ? json.value(key, otherwise) : otherwise;
  }
  bool says(const std::string& words, std::chrono::seconds limit = std::chrono::seconds(20)) {
    return wait_until([&] { return log().find(words) != std::string::npos; }, limit);
  }
  // What it exited with; -1: not within the time.
  int ends(std::chrono::seconds limit = std::chrono::seconds(60)) {
    return process_->wait(kPatience * limit) ? process_->exit_code() : -1;
  }
  int stop() {
    process_->terminate();
    return ends();
  }
  double memory_mb(const char* field = "VmHWM:") {
    for (const std::string& line : lines_of("/proc/" + std::to_string(process_->pid()) + "/status"))
      if (line.starts_with(field)) return std::stod(line.substr(6)) / 1024.0;
    return 0;
  }

 private:
  std::filesystem::path out_, log_;
  std::optional<daemon::ChildProcess> process_;
};

}  // namespace onemap::test
