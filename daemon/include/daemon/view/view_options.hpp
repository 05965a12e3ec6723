#pragma once
#include <optional>
#include <string>
#include <vector>

#include "daemon/options.hpp"
#include "render/renderer.hpp"

namespace onemap::daemon {

// What onemap-view is told.
struct ViewOptions {
  std::string map, png, glb, ply, pcd;
  std::string view = "fit";
  std::vector<std::string> views;  // FILE_VIEW.png of each; empty: FILE.png of the one above
  std::vector<float> eye, target;  // empty, or three
  std::vector<std::string> beside;
  std::string as_in;  // the map of all those, from whose side they are seen; empty: each from its own
  std::string compare;
  float compare_limit_m = 0.05f;
  int turntable = 0, follow_every = 0;  // 0: no sequence
  bool points = false, mesh = false, plain = false, keep_crumbs = false;
  render::Style style;
};

// Status is exit code and text to show when there are no options to run with.
Parsed<ViewOptions> parse_view_options(const std::vector<std::string>& arguments);

}  // namespace onemap::daemon
