#include "daemon/config_files.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>

namespace onemap::daemon {

namespace fs = std::filesystem;

std::string Surroundings::environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

Result<std::vector<std::string>> drop_ins(const std::string& file) {
  const std::string folder = file + ".d";
  std::vector<std::string> files;
  std::error_code error;
  if (!fs::exists(folder, error) && !error) return files;
  // A loop by iterator: the one over a range throws in its ++.
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.ends_with(".toml") && !name.starts_with('.')) files.push_back(entry->path().string());
  }
  if (error) return Error{folder, "cannot read the drop-ins: " + error.message()};
  std::ranges::sort(files);
  return files;
}

std::vector<Error> read_config_files(const std::string& file, bool must_exist, Config& config) {
  std::vector<Error> errors;
  std::error_code error;
  const bool absent = !fs::exists(file, error) && !error;
  if (must_exist || !absent) errors = read_config(file, config);
  const auto more = drop_ins(file);
  if (!more) {
    errors.push_back(more.error());
    return errors;
  }
  for (const std::string& drop_in : *more) std::ranges::move(read_config(drop_in, config), std::back_inserter(errors));
  return errors;
}

DefaultOut default_out(const Surroundings& surroundings) {
  // systemd's list of several folders is separated by colons.
  if (const std::string state = surroundings.variable("STATE_DIRECTORY"); !state.empty())
    return {state.substr(0, state.find(':')), "$STATE_DIRECTORY"};
  if (const std::string state = surroundings.variable("XDG_STATE_HOME"); state.starts_with('/'))
    return {state + "/onemap", "$XDG_STATE_HOME"};
  if (const std::string home = surroundings.variable("HOME"); home.starts_with('/'))
    return {home + "/.local/state/onemap", "$HOME"};
  return {};
}

}  // namespace onemap::daemon
