#pragma once
#include <span>
#include <string>
#include <vector>

namespace onemap::daemon {

// An option of a command line, as its parser knows it.
struct ManOption {
  std::string name, type, text;  // "--camera", "ADDRESS"; no type: a switch
};
// What an exit status says.
struct ManExit {
  int status;
  std::string_view text;
};

// Man pages in man(7)'s language, made of what the programs themselves go by, so that they cannot say anything else:
// onemap.toml(5) of the table of keys, onemapd(8) of the options and the table of cameras.
std::string man_of_config();
std::string man_of_daemon(std::span<const ManOption> options, std::span<const ManExit> exits);

}  // namespace onemap::daemon
