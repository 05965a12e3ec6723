#pragma once
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "control/protocol.hpp"
#include "hal/base/result.hpp"

namespace onemap::daemon {

using control::Json;

// Answers a request that takes long with a DONE, or with an ERROR; from any thread, once, even if nobody listens any
// more.
using Later = std::function<void(Result<Json>)>;

// What a client asks. The object's class is the command's, and it has no other keys than the command knows.
struct Request {
  const Json& object;
  std::set<std::string, std::less<>>& watched;  // what this client hears unasked
  std::function<Later()> later;                 // for a request that is answered with an ACK now
};

enum class Effect : bool { reads, changes };

// One thing that can be asked of a daemon. The handler runs on the loop's thread and must not wait; what it answers
// gets the command's class (or ACK's) in front. Its error's reason goes to the client.
struct Command {
  std::string_view name;
  Effect effect = Effect::reads;
  std::vector<std::string_view> keys;  // beside class and id
  std::string_view text;               // for people
  std::function<Result<Json>(const Request&)> handler;
};

// The command of an object from outside, or what is wrong with it: no object, no class, an unknown one or an unknown
// key (with those that there are), an id that is neither a number nor a short text.
Result<const Command*> find_command(const std::vector<Command>& commands, const Json& object);

// Optional members of a request; the error names the key.
Result<std::string> text_in(const Json& object, std::string_view key, const std::string& otherwise);
Result<bool> flag_in(const Json& object, std::string_view key, bool otherwise);

}  // namespace onemap::daemon
