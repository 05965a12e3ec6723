#pragma once
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace onemap::test {

// What a shell's command said and how it ended. For readers of somebody else that may not be there.
struct Said {
  int status = -1;
  std::string output;  // both streams
};

inline Said say(const std::string& command) {
  Said said;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return said;
  std::array<char, 4096> part{};
  while (fgets(part.data(), part.size(), pipe) != nullptr) said.output += part.data();
  said.status = WEXITSTATUS(pclose(pipe));
  return said;
}

inline bool python_has(const std::string& module) { return say("python3 -c 'import " + module + "'").status == 0; }

}  // namespace onemap::test
