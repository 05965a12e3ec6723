#include "device_file.hpp"

#include <fstream>
#include <functional>
#include <map>
#include <stdexcept>

namespace onemap::test {

DeviceFile read_device_file(const std::filesystem::path& file) {
  DeviceFile out;
  const std::map<std::string, std::function<void(const std::string&)>> keys{
      {"room", [&](const std::string& value) { out.room = value; }},
      {"hz", [&](const std::string& value) { out.hz = std::stod(value); }},
      {"steps", [&](const std::string& value) { out.steps = std::stoi(value) != 0; }},
      {"on_demand", [&](const std::string& value) { out.on_demand = std::stoi(value) != 0; }},
      {"registers", [&](const std::string& value) { out.registers = std::stoi(value) != 0; }},
      {"hundred_um", [&](const std::string& value) { out.hundred_um = std::stoi(value) != 0; }},
      {"clock_restarts", [&](const std::string& value) { out.clock_restarts = std::stoi(value) != 0; }},
      {"depth_late_us", [&](const std::string& value) { out.depth_late_us = std::stoi(value); }},
      {"substitutes", [&](const std::string& value) { out.substitutes = std::stoi(value) != 0; }},
      {"unheard", [&](const std::string& value) { out.unheard = std::stoi(value) != 0; }},
      {"colour", [&](const std::string& value) { out.colour = value; }},
      {"serial", [&](const std::string& value) { out.serial = value; }},
  };
  std::ifstream in(file);
  std::string key, value;
  for (int line = 1; in >> key >> value; ++line) {
    const auto found = keys.find(key);
    if (found == keys.end())
      throw std::runtime_error(file.string() + ":" + std::to_string(line) + ": unknown key " + key);
    found->second(value);
  }
  return out;
}

}  // namespace onemap::test
