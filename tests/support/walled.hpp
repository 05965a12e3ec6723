#pragma once
// A daemon in a world of its own: with mounts or a network that nobody else has.
#include <fmt/format.h>

#include "support/other_program.hpp"
#include "support/running.hpp"

namespace onemap::test {

// Programs in namespaces of their own, with what a shell does there first.
class Walled {
 public:
  Walled(const TempFolder& folder, const std::string& walls, const std::string& first, const std::string& camera,
         const std::string& more, const std::string& id = "robot")
      : out_(folder / "out"), log_(folder / "log.txt") {
    std::filesystem::create_directories(out_);
    const std::string script = fmt::format("{}\nexec {}/onemapd --id {} --camera '{}' --out {} {}", first,
                                           ONEMAP_BIN_DIR, id, camera, out_.string(), more);
    auto child = daemon::ChildProcess::start("/usr/bin/unshare", {walls, "bash", "-e", "-c", script}, log_.string());
    if (child) process_.emplace(std::move(*child));
  }
  // Why it cannot be tried here; empty: it can.
  static std::string missing(const std::string& walls) {
    const auto said = say("unshare " + walls + " true");
    return said.status == 0 ? "" : "no namespaces here (needs root): " + said.output;
  }
  const daemon::ChildProcess& process() const { return *process_; }
  std::string log() const { return text_of(log_); }
  bool says(const std::string& words) {
    return wait_until([&] { return log().find(words) != std::string::npos; }, std::chrono::seconds(60));
  }
  // A file of its world.
  std::filesystem::path in_there(const std::string& name) const {
    return fmt::format("/proc/{}/root{}/{}", process_->pid(), out_.string(), name);
  }
  // What a shell does in its world; its exit status.
  int within(const std::string& command) const {
    return say(fmt::format("nsenter -t {} -m -n sh -c '{}'", process_->pid(), command)).status;
  }
  nlohmann::json status() const { return nlohmann::json::parse(text_of(in_there("status.json")), nullptr, false); }
  std::uint64_t frames() const {
    const auto now = status();
    return now.is_object() ? now.value("frames", 0u) : 0;
  }
  bool goes_on() {
    const auto before = frames();
    return wait_until([&] { return frames() > before + 5; }, std::chrono::seconds(60));
  }
  int stop() {
    process_->terminate();
    return process_->wait(kPatience * std::chrono::seconds(60)) ? process_->exit_code() : -1;
  }
  const std::filesystem::path& out() const { return out_; }

 private:
  std::filesystem::path out_, log_;
  std::optional<daemon::ChildProcess> process_;
};

}  // namespace onemap::test
