#include "control/machine.hpp"

#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <system_error>

namespace onemap::control {

namespace {
constexpr const char* kUser = "onemap";
constexpr const char* kState = "/var/lib/onemap";
constexpr int kNotFound = 127;                         // a shell's
constexpr const char* kPatience = "timeout -k 1 20 ";  // a driver may hang

std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

// The one beside this program, else that of PATH.
std::optional<Told> ask_onemapd(const std::string& options, const std::string& environment) {
  std::error_code error;
  const auto own = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string beside = (own.parent_path() / "onemapd").string();
  const std::string program = std::filesystem::exists(beside, error) ? beside : "onemapd";
  std::FILE* const pipe =
      popen((environment + kPatience + quoted(program) + " " + options + " 2>&1 </dev/null").c_str(), "re");
  if (pipe == nullptr) return std::nullopt;
  Told told;
  std::array<char, 4096> some{};
  for (std::size_t n = 0; (n = std::fread(some.data(), 1, some.size(), pipe)) > 0;) told.text.append(some.data(), n);
  const int status = pclose(pipe);
  told.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return told.status == kNotFound ? std::nullopt : std::optional(std::move(told));
}

std::vector<gid_t> groups_of(const passwd& user) {
  std::vector<gid_t> groups(64);
  int many = static_cast<int>(groups.size());
  getgrouplist(user.pw_name, user.pw_gid, groups.data(), &many);
  groups.resize(static_cast<std::size_t>(std::clamp(many, 0, 64)));
  return groups;
}

Machine of_service(const passwd& user) {
  Machine machine{"", user.pw_uid, groups_of(user), {}};
  if (const group* video = getgrnam("video")) machine.groups.push_back(video->gr_gid);
  machine.onemapd = [](const std::string& options) {
    return ask_onemapd(options, fmt::format("STATE_DIRECTORY={} ", kState));
  };
  return machine;
}
}  // namespace

Machine this_machine() {
  if (const passwd* user = geteuid() == 0 ? getpwnam(kUser) : nullptr) return of_service(*user);
  Machine machine{"", geteuid(), std::vector<gid_t>(64), {}};
  const int many = getgroups(64, machine.groups.data());
  machine.groups.resize(static_cast<std::size_t>(std::max(many, 0)));
  machine.groups.push_back(getegid());
  machine.onemapd = [](const std::string& options) { return ask_onemapd(options, ""); };
  return machine;
}

}  // namespace onemap::control
