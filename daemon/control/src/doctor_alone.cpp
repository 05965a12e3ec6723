#include "control/doctor_alone.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <utility>

#include "control/found_cameras.hpp"
#include "control/key_file.hpp"

namespace onemap::control {

namespace fs = std::filesystem;

namespace {

// Cameras that are no V4L2 nodes: PrimeSense and Xtion, Kinect v1. Empty: any product.
constexpr std::pair<const char*, const char*> kUsbCameras[] = {{"1d27", ""}, {"045e", "02ae"}, {"045e", "02bf"}};

Json good(const char* about, const std::string& text) {
  return {{"about", about}, {"ok", true}, {"text", text}, {"advice", ""}};
}

Json bad(const char* about, const std::string& text, const std::string& advice) {
  return {{"about", about}, {"ok", false}, {"text", text}, {"advice", advice}};
}

bool may_use(const Machine& machine, const struct stat& node) {
  constexpr unsigned kReadWrite = 6;
  const auto allows = [&](unsigned shift) { return (node.st_mode >> shift & kReadWrite) == kReadWrite; };
  if (machine.user == 0) return true;
  if (node.st_uid == machine.user) return allows(6);
  return allows(std::ranges::count(machine.groups, node.st_gid) > 0 ? 3 : 0);
}

// The value of NAME = "VALUE" in what --dump-config says; empty: none.
std::string value_of(const std::string& dump, const std::string& name) {
  std::istringstream in(dump);
  const std::string begin = name + " = \"";
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(begin)) continue;
    const std::size_t end = line.find("\"  # from ", begin.size());
    return end == std::string::npos ? "" : line.substr(begin.size(), end - begin.size());
  }
  return {};
}

Json look_at_config(const Told& check) {
  if (check.status == 0) return good("config", "good");
  return bad("config", check.text.substr(0, check.text.find_last_not_of('\n') + 1),
             "change the line that is named; `onemapd --check-config` says whether it is good then");
}

Json look_at_folder(const Machine& machine, const std::string& out) {
  struct stat found {};
  if (stat((machine.root + out).c_str(), &found) != 0) {
    if (errno == ENOENT) return good("out folder", out + " is not there yet; the daemon makes it");
    return bad("out folder", out + ": " + std::strerror(errno), "let the daemon's user in, or say another robot.out");
  }
  if (!S_ISDIR(found.st_mode)) return bad("out folder", out + " is no folder", "say another robot.out");
  struct statvfs disk {};
  if (statvfs((machine.root + out).c_str(), &disk) == 0 && (disk.f_flag & ST_RDONLY) != 0)
    return bad("out folder", out + " is on a disk that is read-only", "mount -o remount,rw, or say another robot.out");
  if (!may_use(machine, found))
    return bad("out folder",
               fmt::format("uid {} may not write to {} (mode {:04o}, uid {})", machine.user, out,
                           found.st_mode & 07777u, found.st_uid),
               fmt::format("chown -R {} {}", machine.user, out));
  return good("out folder", out + " can be written to");
}

// Whether somebody said that it is there; else there need be none.
enum class Wanted { no, yes };

void look_at_secret(const Machine& machine, const char* about, const std::string& file, std::vector<Json>& findings,
                    Wanted wanted = Wanted::no) {
  struct stat found {};
  if (stat((machine.root + file).c_str(), &found) != 0) {
    if (wanted == Wanted::yes)
      findings.push_back(bad(about, fmt::format("team.key_file is {}: {}", file, std::strerror(errno)),
                             "`onemapctl team join` installs a key; say where it is, or \"none\""));
  } else if ((found.st_mode & 077u) != 0)
    findings.push_back(bad(about, fmt::format("{}: others may use it (mode {:04o})", file, found.st_mode & 07777u),
                           "chmod 600 " + file));
  else if (machine.user != 0 && found.st_uid != machine.user)
    findings.push_back(bad(about,
                           fmt::format("{} belongs to uid {}, and the daemon is {}", file, found.st_uid, machine.user),
                           fmt::format("chown {} {}", machine.user, file)));
  else
    findings.push_back(good(about, file + ", only the daemon reads it"));
}

void look_at_secrets(const Machine& machine, const std::string& key_file, const std::string& out,
                     std::vector<Json>& findings) {
  if (key_file.empty()) {
    look_at_secret(machine, "team key", std::string(kTeamKeyFile), findings);
    look_at_secret(machine, "team key", out + "/team.key", findings);
  } else if (key_file != "none") {
    look_at_secret(machine, "team key", key_file, findings, Wanted::yes);
  }
  look_at_secret(machine, "identity", out + "/identity", findings);
}

std::string word_in(const fs::path& file) {
  std::string word;
  std::ifstream(file) >> word;
  return word;
}

bool is_camera(const fs::path& usb) {
  const std::string vendor = word_in(usb / "idVendor"), product = word_in(usb / "idProduct");
  return std::ranges::any_of(kUsbCameras, [&](const auto& known) {
    return vendor == known.first && (*known.second == '\0' || product == known.second);
  });
}

// Of a camera or of what may be one, in their order.
std::vector<std::string> camera_nodes(const std::string& root) {
  std::vector<std::string> nodes;
  std::error_code error;
  for (fs::directory_iterator at(root + "/dev", error), end; !error && at != end; at.increment(error))
    if (const std::string name = at->path().filename().string(); name.starts_with("video"))
      nodes.push_back("/dev/" + name);
  for (fs::directory_iterator at(root + "/sys/bus/usb/devices", error), end; !error && at != end; at.increment(error)) {
    if (!is_camera(at->path())) continue;
    const std::string bus = word_in(at->path() / "busnum"), number = word_in(at->path() / "devnum");
    nodes.push_back(fmt::format("/dev/bus/usb/{:0>3}/{:0>3}", bus, number));
  }
  std::ranges::sort(nodes);
  return nodes;
}

void look_at_nodes(const Machine& machine, std::vector<Json>& findings) {
  std::vector<std::string> usable;
  const auto nodes = camera_nodes(machine.root);
  for (const std::string& node : nodes) {
    struct stat found {};
    if (stat((machine.root + node).c_str(), &found) != 0) continue;  // pulled out just now
    if (may_use(machine, found)) {
      usable.push_back(node);
      continue;
    }
    findings.push_back(bad("camera",
                           fmt::format("{}: uid {} may not open it (mode {:04o}, gid {})", node, machine.user,
                                       found.st_mode & 07777u, found.st_gid),
                           "`udevadm trigger` gives it to the service (70-onemap-cameras.rules); a user's daemon wants "
                           "him in the group video: usermod -aG video USER"));
  }
  if (nodes.empty())
    findings.push_back(bad("camera", "there is no /dev/video* and no USB camera that is known",
                           "plug it in; `onemapd --cameras` says what is there, and why it cannot be used"));
  else if (!usable.empty())
    findings.push_back(good("camera", fmt::format("{} can be opened", fmt::join(usable, ", "))));
}

// Cameras that work and do less than they could.
void look_at_limits(const Machine& machine, std::vector<Json>& findings) {
  const auto found = found_cameras(machine);
  if (!found) return;
  for (const Json& camera : found->at("found"))
    if (const std::string limits = camera.value("limits", ""); !limits.empty())
      findings.push_back(
          bad("camera", camera.value("address", "") + " " + limits, "plug it into a port that is as fast as it is"));
}

bool needs_hardware(const std::string& camera) {
  return !camera.starts_with("replay:") && !camera.starts_with("simulated:");
}

}  // namespace

std::vector<Json> findings_without_daemon(const Error& why, const Machine& machine) {
  std::vector<Json> findings{
      bad("daemon", why.text(),
          "systemctl start onemapd; if it ends again, `journalctl -u onemapd -p warning -e` says why")};
  const auto check = machine.onemapd("--check-config"), dump = machine.onemapd("--dump-config");
  if (!check || !dump) {
    findings.push_back(bad("config", "the program onemapd is not found", "install it, or set PATH"));
    look_at_secret(machine, "team key", std::string(kTeamKeyFile), findings);
  } else {
    findings.push_back(look_at_config(*check));
  }
  const std::string out = dump && dump->status == 0 ? value_of(dump->text, "out") : "";
  if (!out.empty()) {
    findings.push_back(look_at_folder(machine, out));
    look_at_secrets(machine, value_of(dump->text, "key_file"), out, findings);
  }
  if (out.empty() || needs_hardware(value_of(dump->text, "camera"))) {
    look_at_nodes(machine, findings);
    look_at_limits(machine, findings);
  }
  return findings;
}

}  // namespace onemap::control
