#pragma once
#include <filesystem>
#include <string>

#include "support/temp_folder.hpp"

namespace onemap::test {

// A team's key in a file that only its owner reads; its path.
inline std::string team_key(const TempFolder& folder, const std::string& name = "team.key", char digit = '5') {
  folder.write(name, "onemap-team-key-1 " + std::string(64, digit) + "\n");
  const std::filesystem::path file = folder / name;
  std::filesystem::permissions(file, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  return file.string();
}

}  // namespace onemap::test
