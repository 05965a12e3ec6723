#include "daemon/pictures.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string_view>

#include "daemon/clock.hpp"
#include "daemon/fleet/child_process.hpp"
#include "hal/base/file.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

namespace {

namespace fs = std::filesystem;
constexpr const char* kViewer = "onemap-view";
constexpr Duration kLookForStop = std::chrono::milliseconds(100);  // whether somebody wants it no longer

// Beside this program, or where programs are.
Result<std::string> viewer() {
  std::error_code none;
  const fs::path own = fs::read_symlink("/proc/self/exe", none);
  std::string places = own.parent_path().string();
  if (const char* path = std::getenv("PATH"); path != nullptr) places += std::string(":") + path;
  for (std::size_t at = 0; at <= places.size();) {
    const std::size_t end = std::min(places.find(':', at), places.size());
    const std::string program = places.substr(at, end - at) + "/" + kViewer;
    if (access(program.c_str(), X_OK) == 0) return program;
    at = end + 1;
  }
  return Error{kViewer, "neither beside this program nor in PATH: no pictures"};
}

std::string last_line(std::string_view text) {
  while (text.ends_with('\n')) text.remove_suffix(1);
  const std::size_t at = text.rfind('\n');
  return printable(at == std::string_view::npos ? text : text.substr(at + 1));
}

// One drawing on its way. Its input and its output file go with it.
class Drawing {
 public:
  Drawing(const std::string& program, const MapPicture& picture, const PictureLimits& limits)
      : stem_(picture.stem), input_(stem_ + ".drawing.omap"), log_(stem_ + ".drawing.log") {
    if (auto written = write_file(input_, picture.map); !written) {
      result_.status = written;
      return;
    }
    auto child = ChildProcess::start(program, arguments(picture), log_, {limits.address_space_bytes, limits.niceness});
    if (child)
      child_.emplace(std::move(*child));
    else
      result_.status = child.error();
  }
  ~Drawing() {
    std::error_code none;
    for (const std::string& file : {input_, log_}) fs::remove(file, none);
  }
  Drawing(const Drawing&) = delete;
  Drawing& operator=(const Drawing&) = delete;

  PictureResult wait(Instant until, const std::function<bool()>& cancelled) {
    if (!child_) return result_;
    bool ended = false, left_off = false;
    while (!ended && !left_off && now() < until) {
      ended = child_->wait(std::clamp<Duration>(until - now(), Duration::zero(), kLookForStop));
      left_off = !ended && cancelled && cancelled();
    }
    result_.killed = !ended || child_->exit_code() >= 128;
    if (left_off)
      result_.status = Error{stem_, "drawing was left off"};
    else if (!ended)
      result_.status = Error{stem_, "drawing took too long and was ended"};
    else if (child_->exit_code() != 0)
      result_.status = Error{stem_, fmt::format("drawing failed ({}): {}", child_->exit_text(), last_line(output()))};
    else
      read_size();
    child_.reset();
    return result_;
  }

 private:
  std::vector<std::string> arguments(const MapPicture& picture) const {
    std::vector<std::string> words{input_};
    if (picture.png) words.insert(words.end(), {"--png", stem_ + ".png"});
    if (picture.glb) words.insert(words.end(), {"--glb", stem_ + ".glb"});
    if (picture.points) words.insert(words.end(), {"--ply", stem_ + ".ply", "--pcd", stem_ + ".pcd"});
    if (picture.png && !picture.views.empty()) words.emplace_back("--views");
    if (picture.png) words.insert(words.end(), picture.views.begin(), picture.views.end());
    return words;
  }
  std::string output() const {
    auto text = read_text_file(log_);
    return text ? std::move(*text) : std::string();
  }
  void read_size() {
    // "FILE: N points, ..." is the first thing that it says.
    const std::string text = output();
    const std::string_view rest = std::string_view(text).substr(std::min(text.size(), printable(input_).size()));
    unsigned long long vertices = 0;
    if (std::sscanf(std::string(rest).c_str(), ": %llu points", &vertices) != 1)  // NOLINT(cert-err34-c)
      result_.status = Error{stem_, "drawing did not say what it wrote"};
    result_.vertices = vertices;
  }

  const std::string stem_, input_, log_;
  std::optional<ChildProcess> child_;
  PictureResult result_;
};

}  // namespace

std::vector<PictureResult> write_pictures(const std::vector<MapPicture>& pictures, const PictureLimits& limits) {
  const auto program = viewer();
  if (!program) return std::vector<PictureResult>(pictures.size(), {program.error(), 0, false});
  const Instant until = now() + limits.time;
  std::vector<std::unique_ptr<Drawing>> drawings;
  drawings.reserve(pictures.size());
  for (const MapPicture& picture : pictures) drawings.push_back(std::make_unique<Drawing>(*program, picture, limits));
  std::vector<PictureResult> results;
  results.reserve(drawings.size());
  for (const auto& drawing : drawings) results.push_back(drawing->wait(until, limits.cancelled));
  return results;
}

}  // namespace onemap::daemon
