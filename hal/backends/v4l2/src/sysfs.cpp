#include "sysfs.hpp"

#include <dirent.h>

#include <algorithm>
#include <climits>
#include <cstdlib>
#include <memory>

#include "hal/base/file.hpp"
#include "hal/base/text.hpp"

namespace onemap::hal::v4l2 {

namespace {

constexpr const char* kClass = "/sys/class/video4linux/";
constexpr std::size_t kLongestAttribute = 256;

struct CloseFolder {
  void operator()(DIR* folder) const { closedir(folder); }
};

// The first line of an attribute, made printable (a device chooses its own names); empty when there is none.
std::string attribute(const std::string& folder, const char* name) {
  const auto text = read_text_file(folder + "/" + name, kSmallFileBytes);
  if (!text) return {};
  std::string line = text->substr(0, std::min(text->find('\n'), kLongestAttribute));
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return printable(line);
}

std::string real_path(const std::string& path) {
  const std::unique_ptr<char, decltype(&std::free)> real(realpath(path.c_str(), nullptr), &std::free);
  return real ? real.get() : "";
}

std::string parent(const std::string& path) { return path.substr(0, path.rfind('/')); }

// The folder of the USB device above a node's folder, or the folder of what else it belongs to.
std::string device_above(const std::string& interface) {
  for (std::string folder = interface; folder.size() > 5; folder = parent(folder))
    if (!attribute(folder, "idVendor").empty()) return folder;
  return interface;
}

NodePlace look_at(const std::string& name) {
  NodePlace node;
  node.path = "/dev/" + name;
  const std::string folder = real_path(kClass + name);
  if (folder.empty()) return node;
  node.interface = parent(parent(folder));  // .../1-2:1.0/video4linux/video0
  node.device = device_above(node.interface);
  node.name = attribute(folder, "name");
  node.index = std::atoi(attribute(folder, "index").c_str());
  const std::string vendor = attribute(node.device, "idVendor");
  if (!vendor.empty()) node.usb_id = vendor + ":" + attribute(node.device, "idProduct");
  node.product = attribute(node.device, "product");
  node.serial = attribute(node.device, "serial");
  node.speed = attribute(node.device, "speed");
  node.usb_version = attribute(node.device, "version");
  return node;
}

}  // namespace

std::vector<NodePlace> find_nodes() {
  std::vector<std::pair<int, std::string>> names;
  const std::unique_ptr<DIR, CloseFolder> folder(opendir(kClass));
  while (const dirent* entry = folder ? readdir(folder.get()) : nullptr) {
    const std::string name = entry->d_name;
    if (name.starts_with("video")) names.emplace_back(std::atoi(name.c_str() + 5), name);
  }
  std::sort(names.begin(), names.end());
  std::vector<NodePlace> nodes;
  nodes.reserve(names.size());
  for (const auto& [number, name] : names) nodes.push_back(look_at(name));
  return nodes;
}

}  // namespace onemap::hal::v4l2
