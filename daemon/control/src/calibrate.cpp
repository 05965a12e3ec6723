#include "control/calibrate.hpp"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

namespace onemap::control {

Error become_calibrate(const std::vector<std::string>& words) {
  std::string program = "onemap-calibrate";
  std::error_code none;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", none);
  const std::string beside = (own.parent_path() / program).string();
  std::vector<char*> arguments{program.data()};
  std::vector<std::string> copies = words;
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(beside.c_str(), arguments.data());
  execvp(program.c_str(), arguments.data());
  return {program,
          "cannot be run, neither beside this program nor from PATH: " + std::generic_category().message(errno)};
}

}  // namespace onemap::control
