#include "control/socket_place.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace onemap::control {

namespace fs = std::filesystem;

namespace {
std::string value(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? "" : text;
}

void add_sockets(const fs::path& folder, std::vector<std::string>& found, int deep) {
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code gone;
    if (at->is_socket(gone) && at->path().extension() == ".sock")
      found.push_back(at->path().string());
    else if (deep > 0 && at->is_directory(gone))
      add_sockets(at->path(), found, deep - 1);
  }
}
}  // namespace

Environment environment() {
  const std::string folders = value("RUNTIME_DIRECTORY");
  return {folders.substr(0, folders.find(':')), value("XDG_RUNTIME_DIR"), value("ONEMAP_SOCKET")};
}

std::string default_socket(const Environment& environment, const std::string& id, const std::string& out) {
  if (!environment.runtime_directory.empty()) return environment.runtime_directory + "/control.sock";
  if (!environment.xdg_runtime_dir.empty()) return environment.xdg_runtime_dir + "/onemap/" + id + ".sock";
  return out + "/control.sock";
}

std::vector<std::string> likely_sockets(const Environment& environment, const std::string& run) {
  if (!environment.socket.empty()) return {environment.socket};
  std::vector<std::string> found;
  if (!environment.runtime_directory.empty()) add_sockets(environment.runtime_directory, found, 0);
  add_sockets(run, found, 1);
  if (!environment.xdg_runtime_dir.empty()) add_sockets(environment.xdg_runtime_dir + "/onemap", found, 0);
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace onemap::control
