#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include "control/line_reader.hpp"
#include "control/protocol.hpp"
#include "daemon/config.hpp"
#include "daemon/control/command.hpp"
#include "daemon/saved_map.hpp"
#include "fuzz/expect.hpp"
#include "fuzz/targets.hpp"

namespace onemap::fuzz {

namespace {
// A file that is only in memory.
class MemoryFile {
 public:
  explicit MemoryFile(Bytes bytes) : descriptor_(memfd_create("input", 0)) {
    ONEMAP_FUZZ_EXPECT(descriptor_ >= 0);
    ONEMAP_FUZZ_EXPECT(write(descriptor_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};
}  // namespace

void config(Bytes input) {
  const MemoryFile file(input);
  daemon::Config config;
  const auto errors = daemon::read_config(file.path(), config);
  for (const Error& error : errors) ONEMAP_FUZZ_EXPECT(!error.reason.empty());
}

void control(Bytes input) {
  static const std::vector<daemon::Command> commands{{"STATUS", daemon::Effect::reads, {"watch"}, "", {}},
                                                     {"SNAPSHOT", daemon::Effect::changes, {"path", "what"}, "", {}}};
  control::LineReader lines(control::kMostLineBytes);
  // As a socket gives it: in pieces.
  for (std::size_t at = 0; at < input.size();) {
    const std::size_t piece = std::min<std::size_t>(1 + input[at] * 3u, input.size() - at);
    lines.add({reinterpret_cast<const char*>(input.data()) + at, piece});
    at += piece;
    control::LineReader::Line line;
    while (lines.next(line)) {
      ONEMAP_FUZZ_EXPECT(line.text.size() <= control::kMostLineBytes);
      const control::Json object = control::Json::parse(line.text, nullptr, false);
      if (object.is_discarded()) continue;
      const auto command = daemon::find_command(commands, object);
      if (!command) {
        ONEMAP_FUZZ_EXPECT(!command.error().reason.empty());
        continue;
      }
      (void)daemon::text_in(object, "path", "map.ply");
      (void)daemon::flag_in(object, "watch", false);
    }
    ONEMAP_FUZZ_EXPECT(lines.held() <= control::kMostLineBytes + 1);
  }
}

void saved_map(Bytes input) {
  const auto scene = daemon::load_map("input", input);
  if (!scene) ONEMAP_FUZZ_EXPECT(!scene.error().reason.empty());
}

}  // namespace onemap::fuzz
