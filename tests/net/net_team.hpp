#pragma once
// Real daemons, each in a network namespace of its own, with emulated links between them.
#include <fmt/format.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "sim/topology.hpp"
#include "support/emulated_net.hpp"
#include "support/patience.hpp"
#include "support/team_key.hpp"
#include "support/temp_folder.hpp"
#include "support/text_of.hpp"

namespace onemap::test {

class NetTeam {
 public:
  // Links between robots; each walks through a part of a simulated room, and then keeps what it knows.
  NetTeam(std::size_t robots, std::vector<comms::sim::Edge> edges, const LinkTraits& traits, int frames)
      : edges_(std::move(edges)), traits_(traits), frames_(frames), children_(robots, -1) {
    std::vector<EmulatedNet::Link> links;
    for (const auto& [a, b] : edges_) links.push_back({a, b, traits, traits});
    auto net = EmulatedNet::open(robots, links, 7);
    if (!net) {
      missing_ = net.error().text();
      return;
    }
    net_ = std::move(*net);
    key_ = team_key(folder_);
    folder_.write("robot.toml",
                  "[run]\nlost_after_s = 300\nlinger_s = 0\nmerge_while_mapping_s = 2\n[map]\nrefresh_plan = false\n"
                  "budget_mb = 32\nglobal_budget_mb = 64\n");
    for (std::size_t i = 0; i < robots; ++i) start(i);
  }
  ~NetTeam() {
    for (std::size_t i = 0; i < children_.size(); ++i) end(i, SIGKILL);
  }
  NetTeam(const NetTeam&) = delete;
  NetTeam& operator=(const NetTeam&) = delete;

  const std::string& missing() const { return missing_; }  // why it cannot be tried here; empty: it can
  EmulatedNet& net() { return *net_; }
  std::size_t size() const { return children_.size(); }

  void start(std::size_t i) {
    std::string command = fmt::format(
        "exec {0}/onemapd --id {1} --out {2} --team-key {3} --config {4} --listen 0.0.0.0:4600 --speed 0.5 --camera "
        "'simulated:living-room?robot={5}&robots={6}&frames={7}&seed=3&width=160&height=120'",
        ONEMAP_BIN_DIR, name(i), out(i), key_, folder_ / "robot.toml", i + 1, size(), frames_);
    for (std::size_t link = 0; link < edges_.size(); ++link) {
      const auto& [a, b] = edges_[link];
      if (a == i) command += fmt::format(" --peer {}:4600", net_->address(link, b));
      if (b == i) command += fmt::format(" --peer {}:4600", net_->address(link, a));
    }
    command += fmt::format(" >>{0} 2>&1", log_of(i));
    children_[i] = net_->start(i, {"/bin/sh", "-c", command});
  }
  void end(std::size_t i, int signal) {
    if (children_[i] <= 0) return;
    kill(children_[i], signal);
    int status = 0;
    waitpid(children_[i], &status, 0);
    children_[i] = -1;
  }
  void signal(std::size_t i, int number) { kill(children_[i], number); }

  nlohmann::json status(std::size_t i) const {
    return nlohmann::json::parse(text_of(out(i) + "/status.json"), nullptr, false);
  }
  template <class T>
  T status(std::size_t i, const char* key, T otherwise) const {
    const auto json = status(i);
    return json.is_object() ? json.value(key, otherwise) : otherwise;
  }
  int keyframes(std::size_t i) const { return status(i, "keyframes", 0); }
  // All have finished, know all others, and hold the same records and the same map.
  bool equal() const {
    std::set<std::string> frontiers, maps;
    for (std::size_t i = 0; i < size(); ++i) {
      const auto json = status(i);
      if (!json.is_object() || json.value("robots_finished", std::size_t{0}) < size()) return false;
      if (!json.value("map_agreed", false)) return false;
      frontiers.insert(json.value("frontier_digest", ""));
      maps.insert(json.value("map_digest", ""));
    }
    return frontiers.size() == 1 && maps.size() == 1;
  }
  std::string words() const {
    std::string all;
    for (std::size_t i = 0; i < size(); ++i) {
      const auto json = status(i);
      if (!json.is_object()) continue;
      all += fmt::format("{}: frames {}, finished {}, frontier {}, map {}, agreed {}\n", name(i),
                         json.value("frames", 0), json.value("robots_finished", 0), json.value("frontier_digest", ""),
                         json.value("map_digest", ""), json.value("map_agreed", false));
    }
    return all;
  }
  std::string log(std::size_t i) const { return text_of(log_of(i)); }

 private:
  static std::string name(std::size_t i) { return std::string(1, static_cast<char>('a' + i)); }
  std::string out(std::size_t i) const { return folder_ / name(i); }
  std::string log_of(std::size_t i) const { return folder_ / (name(i) + ".log"); }

  const TempFolder folder_;
  std::vector<comms::sim::Edge> edges_;
  LinkTraits traits_;
  int frames_;
  std::string key_, missing_;
  std::vector<pid_t> children_;
  std::unique_ptr<EmulatedNet> net_;
};

}  // namespace onemap::test
