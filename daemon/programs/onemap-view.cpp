// onemap-view: a saved map to pictures or to another model format, without a display.
#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "daemon/view/view.hpp"

int main(int argc, char** argv) try {
  using namespace onemap::daemon;
  const auto parsed = parse_view_options(argc, argv);
  if (!parsed.value) {
    fmt::print(parsed.exit == Exit::done ? stdout : stderr, "{}", parsed.text);
    return static_cast<int>(parsed.exit);
  }
  if (auto done = run_view(*parsed.value); !done) {
    fmt::print(stderr, "onemap-view: {}\n", done.error().text());
    return static_cast<int>(Exit::failed);
  }
  return 0;
} catch (const std::exception& e) {  // out of memory, or a closed standard output
  (void)std::fputs("onemap-view: ", stderr);
  (void)std::fputs(e.what(), stderr);
  (void)std::fputs("\n", stderr);
  return 1;
}
