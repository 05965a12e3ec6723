#pragma once
// A real daemon with its control socket, for tests that are rude to it.
#include <fmt/format.h>

#include <regex>

#include "support/control_talk.hpp"
#include "support/running.hpp"

namespace onemap::test {

class ControlRobot {
 public:
  static constexpr const char* kCamera =
      "simulated:living-room?robot=1&robots=3&frames=1000000&seed=3&width=320&height=240";

  explicit ControlRobot(const TempFolder& folder, const std::string& more = {}) : socket_(folder / "c.sock") {
    folder.write(
        "control.toml",
        fmt::format("[control]\nsocket = \"{}\"\ntcp = \"127.0.0.1:0\"\nmetrics = \"127.0.0.1:0\"\n{}", socket_, more));
    robot_.emplace(folder, "r1", kCamera,
                   std::vector<std::string>{"--config", folder / "control.toml", "--speed", "0.5"});
    if (!wait_until([&] { return ask_once(R"({"class":"STATUS"})").value("frames", 0) > 2; }, std::chrono::seconds(60)))
      throw std::runtime_error("the daemon does not work: " + robot_->log());
  }
  Robot& operator*() { return *robot_; }
  Robot* operator->() { return &*robot_; }
  pid_t pid() { return robot_->process().pid(); }
  const std::string& socket() const { return socket_; }

  // A client that has heard the greeting.
  Talk talk() const {
    Talk talk(socket_);
    EXPECT_EQ(talk.connected() ? talk.hear().value("class", "") : "none", "VERSION");
    return talk;
  }
  control::Json ask_once(const std::string& request) const {
    Talk talk(socket_);
    if (!talk.connected() || !talk.hear().is_object() || !talk.ask(request)) return control::Json::object();
    auto answer = talk.hear();
    return answer.is_object() ? answer : control::Json::object();
  }
  // It maps on: frames come, and are answered for.
  bool maps_on() const {
    const auto frames = [&] { return ask_once(R"({"class":"STATUS"})").value("frames", 0); };
    const int before = frames();
    return wait_until([&] { return frames() > before + 2; }, std::chrono::seconds(60));
  }
  std::string metrics() const { return ask_once(R"({"class":"METRICS"})").value("text", ""); }
  // A port of loopback that its log names after these words.
  std::uint16_t port_after(const std::string& words) const {
    std::smatch found;
    const std::string log = robot_->log();
    const std::regex port(words + "127\\.0\\.0\\.1:([0-9]+)");
    return std::regex_search(log, found, port) ? static_cast<std::uint16_t>(std::stoi(found[1])) : std::uint16_t{0};
  }

 private:
  const std::string socket_;
  std::optional<Robot> robot_;
};

}  // namespace onemap::test
