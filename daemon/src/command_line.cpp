#include "daemon/command_line.hpp"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <system_error>

#include "control/wrapped.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

std::optional<Ending> parse_command_line(CLI::App& app, const std::vector<std::string>& arguments) {
  app.set_version_flag("--version", app.get_name() + " " ONEMAP_VERSION);
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));  // as CLI11 wants them
  } catch (const CLI::CallForHelp&) {
    return Ending{Exit::done, control::wrapped(app.help())};
  } catch (const CLI::CallForVersion& version) {
    return Ending{Exit::done, std::string(version.what()) + "\n"};
  } catch (const CLI::ParseError& error) {
    return Ending{Exit::usage,
                  complaint(app.get_name(), error.what()) + app.get_name() + " --help says what there is\n"};
  }
  return std::nullopt;
}

std::string complaint(const std::string& program, const std::string& what) {
  return program + ": " + printable(what) + "\n";
}

int end(const Ending& ending) {
  std::FILE* const out = ending.exit == Exit::done ? stdout : stderr;
  // Said here: of a text longer than the stream's buffer, a later flush forgets what could not be written.
  if (std::fputs(ending.text.c_str(), out) < 0 && out == stdout)
    throw std::system_error(errno, std::generic_category(), "standard output");
  return static_cast<int>(ending.exit);
}

int run_program(const std::string& name, int argc, char** argv,
                const std::function<int(const std::vector<std::string>&)>& body) {
  // Ignored by whoever started us, our children's exit statuses would be lost.
  (void)std::signal(SIGCHLD, SIG_DFL);
  (void)std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of a write, which says which
  std::string failure;
  int status = static_cast<int>(Exit::failed);
  try {
    status = body({argv + std::min(argc, 1), argv + argc});
    if (std::fflush(stdout) != 0)
      failure = std::string("standard output: ") + std::strerror(errno);
    else if (std::ferror(stdout) != 0)
      failure = "standard output: not all of it could be written";
  } catch (const std::bad_alloc&) {
    failure = "out of memory";
  } catch (const std::exception& error) {
    failure = error.what();
  }
  if (failure.empty()) return status;
  std::fputs(complaint(name, failure).c_str(), stderr);
  return static_cast<int>(Exit::failed);
}

}  // namespace onemap::daemon
