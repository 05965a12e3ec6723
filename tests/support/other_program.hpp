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

// A Python that has the module; empty: none. Debian's modules are of its own Python, which may not be the first in
// PATH.
inline std::string python_with(const std::string& module) {
  for (const std::string python : {"python3", "/usr/bin/python3"})
    if (say(python + " -c 'import " + module + "'").status == 0) return python;
  return {};
}

}  // namespace onemap::test
