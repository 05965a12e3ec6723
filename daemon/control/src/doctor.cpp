#include "control/doctor.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/timex.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace onemap::control {

namespace {
Json finding(const char* about, bool ok, const std::string& text, const std::string& advice) {
  return {{"about", about}, {"ok", ok}, {"text", text}, {"advice", ok ? "" : advice}};
}

Json look_at_socket(const std::string& socket) {
  struct stat at {};
  if (stat(socket.c_str(), &at) != 0)
    return finding("socket", false, socket + ": " + std::strerror(errno), "the daemon makes it when it starts");
  struct stat folder {};
  const std::string parent = std::filesystem::absolute(socket).parent_path().string();
  const bool exposed =
      stat(parent.c_str(), &folder) == 0 && (folder.st_mode & S_IWOTH) != 0 && (folder.st_mode & S_ISVTX) == 0;
  const std::string text =
      fmt::format("{}, mode {:o}, uid {}, gid {}", socket, at.st_mode & 07777u, at.st_uid, at.st_gid);
  if (exposed)
    return finding("socket", false,
                   parent + " can be written to by everybody, who could put another socket in its place",
                   "chmod o-w " + parent);
  return finding("socket", true, text, "");
}

}  // namespace

Json look_at_clock() {
  timex state{};
  const bool synchronised = adjtimex(&state) != TIME_ERROR;
  return finding(
      "system clock", true,
      synchronised ? "synchronised" : "not synchronised; the daemon does not need it, the dates of its files do", "");
}

std::vector<Json> own_findings(const std::string& socket) { return {look_at_socket(socket), look_at_clock()}; }

}  // namespace onemap::control
