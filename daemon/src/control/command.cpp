#include "daemon/control/command.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/base/text.hpp"

namespace onemap::daemon {

namespace {
constexpr std::size_t kMostIdBytes = 64;

Error wrong(std::string reason) { return {"", std::move(reason)}; }

// What is short_quoted of a stranger's words.
std::string short_quoted(const std::string& text) { return fmt::format("'{}'", printable(text).substr(0, 64)); }

template <class Names>
std::string list(const Names& names) {
  std::string text;
  for (const auto& name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

std::string class_names(const std::vector<Command>& commands) {
  std::vector<std::string_view> names;
  names.reserve(commands.size());
  for (const Command& command : commands) names.push_back(command.name);
  return list(names);
}

Status check_id(const Json& object) {
  const auto id = object.find("id");
  if (id == object.end() || id->is_number_integer()) return success();
  if (id->is_string() && id->get_ref<const std::string&>().size() <= kMostIdBytes) return success();
  return wrong(fmt::format("id: expected a whole number or a text of at most {} bytes", kMostIdBytes));
}

Status check_keys(const Command& command, const Json& object) {
  for (const auto& [key, value] : object.items()) {
    if (key == "class" || key == "id" || std::ranges::find(command.keys, key) != command.keys.end()) continue;
    const std::string known = command.keys.empty() ? "it has none" : "it has " + list(command.keys);
    return wrong(fmt::format("{} has no key {}; {}", command.name, short_quoted(key), known));
  }
  return success();
}
}  // namespace

Result<const Command*> find_command(const std::vector<Command>& commands, const Json& object) {
  if (!object.is_object()) return wrong("expected a JSON object");
  const auto name = object.find("class");
  if (name == object.end() || !name->is_string()) return wrong("expected a \"class\": " + class_names(commands));
  const auto& text = name->get_ref<const std::string&>();
  const auto command = std::ranges::find(commands, text, &Command::name);
  if (command == commands.end())
    return wrong(fmt::format("unknown class {}; known: {}", short_quoted(text), class_names(commands)));
  if (auto status = check_id(object); !status) return status.error();
  if (auto status = check_keys(*command, object); !status) return status.error();
  return &*command;
}

Result<std::string> text_in(const Json& object, std::string_view key, const std::string& otherwise) {
  const auto value = object.find(key);
  if (value == object.end()) return otherwise;
  if (!value->is_string()) return wrong(fmt::format("{}: expected a text", key));
  return value->get<std::string>();
}

Result<bool> flag_in(const Json& object, std::string_view key, bool otherwise) {
  const auto value = object.find(key);
  if (value == object.end()) return otherwise;
  if (!value->is_boolean()) return wrong(fmt::format("{}: expected true or false", key));
  return value->get<bool>();
}

}  // namespace onemap::daemon
