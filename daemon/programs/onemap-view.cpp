// onemap-view: a saved map to pictures or to another model format, without a display.
#include "daemon/command_line.hpp"
#include "daemon/heap.hpp"
#include "daemon/view/view.hpp"

int main(int argc, char** argv) {
  using namespace onemap::daemon;
  constexpr const char* kProgram = "onemap-view";
  keep_memory();
  return run_program(kProgram, argc, argv, [](const std::vector<std::string>& arguments) {
    const auto parsed = parse_view_options(arguments);
    if (!parsed.value) return end(parsed);
    const auto done = run_view(*parsed.value);
    return end(done ? Ending{} : Ending{Exit::failed, complaint(kProgram, done.error().text())});
  });
}
