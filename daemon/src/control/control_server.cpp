#include "daemon/control/control_server.hpp"

#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "daemon/worker.hpp"

namespace onemap::daemon {

using control::LineReader;

namespace {
constexpr std::size_t kMostStepsATurn = 64;                      // lines and reads
constexpr std::size_t kPauseReading = control::kMostUnread / 4;  // answers that wait to be read
constexpr std::uint64_t kMostStalled_s = 10;
constexpr int kMostAccepted = 64;  // at once

Json with_class(std::string_view name, const Json* asked) {
  Json object{{"class", name}};
  if (asked != nullptr && asked->is_object() && asked->contains("id")) object["id"] = asked->at("id");
  return object;
}

Json joined(Json head, const Json& rest) {
  if (rest.is_object()) head.update(rest);
  return head;
}
}  // namespace

struct ControlServer::Client {
  ClientId id = 0;
  int descriptor = -1;
  Caller caller;
  EventLoop::Id watch = 0;
  LineReader reader{control::kMostLineBytes};
  OutputBuffer output;
  std::set<std::string, std::less<>> watched;
  std::uint32_t interest = EventLoop::kReadable;
  std::size_t waiting = 0;     // requests that are answered later
  std::size_t taken_seen = 0;  // of the output, at the last look
  std::uint64_t stalled_s = 0;
  bool asked = false;  // ever
  bool ended = false;  // sends nothing more
  bool gone = false;   // to be closed

  ~Client() { ::close(descriptor); }
};

ControlServer::ControlServer(EventLoop& loop, std::vector<Command> commands, const Json& greeting, Log& log)
    : loop_(loop),
      commands_(std::move(commands)),
      greeting_(control::line_of(greeting)),
      log_(log),
      self_(std::make_shared<ControlServer*>(this)) {}

ControlServer::~ControlServer() {
  *self_ = nullptr;
  if (timer_ != 0) loop_.forget(timer_);
  for (const auto& door : doors_) loop_.forget(door->watch);
  for (const auto& [id, client] : clients_) loop_.forget(client->watch);
}

Status ControlServer::serve(Listener listener) {
  if (timer_ == 0) {
    const auto timer = loop_.every(std::chrono::seconds(1), [this] { look(); });
    if (!timer) return timer.error();
    timer_ = *timer;
  }
  auto door = std::make_unique<Door>(Door{std::move(listener)});
  const auto watch = loop_.watch(door->listener.descriptor(), EventLoop::kReadable,
                                 [this, at = door.get()](std::uint32_t) { accept_some(*at); });
  if (!watch) return watch.error();
  door->watch = *watch;
  doors_.push_back(std::move(door));
  return success();
}

// The loop tells again of those that are left.
void ControlServer::accept_some(Door& door) {
  for (int i = 0; i < kMostAccepted; ++i) {
    int descriptor = -1;
    const Listener::Got got = door.listener.accept(descriptor);
    if (got == Listener::Got::nothing) return;
    if (got == Listener::Got::connection) {
      admit(descriptor, door);
      continue;
    }
    ++counters_.dropped["no_descriptors"];
    log_.limited("control descriptors",
                 "control: no descriptor is left for another client; raise the limit of open files (LimitNOFILE=)");
    door.paused = true;  // until the next look: who waits waits, and the loop does not turn for him
    return loop_.change(door.watch, 0);
  }
}

void ControlServer::admit(int descriptor, const Door& door) {
  auto client = std::make_unique<Client>();
  client->descriptor = descriptor;
  client->caller = caller_of(descriptor, door.listener);
  client->id = ++last_;
  ++counters_.accepted;
  if (clients_.size() >= control::kMostClients && !make_room()) {
    Json full = with_class("ERROR", nullptr);
    full["message"] = fmt::format("{} clients are here already: no room", clients_.size());
    client->output.add(control::line_of(full));
    client->output.flush(descriptor);
    return drop(*client, "too_many", "is one too many");
  }
  const auto watch = loop_.watch(descriptor, EventLoop::kReadable,
                                 [this, id = client->id](std::uint32_t events) { ready(id, events); });
  if (!watch) return drop(*client, "no_descriptors", watch.error().reason.c_str());
  client->watch = *watch;
  Client& here = *clients_.emplace(client->id, std::move(client)).first->second;
  say_line(here, greeting_);
  settle(here.id);
}

// One who has said nothing yet goes, the one who came first.
bool ControlServer::make_room() {
  for (const auto& [id, client] : clients_) {
    if (client->asked) continue;
    drop(*client, "crowded_out", "said nothing, and all places were taken");
    settle(id);
    return true;
  }
  return false;
}

void ControlServer::ready(ClientId id, std::uint32_t events) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  Client& client = *found->second;
  if (events & EPOLLOUT) client.gone = !client.output.flush(client.descriptor) || client.gone;
  if (!client.gone) work(client);
  if ((events & (EPOLLHUP | EPOLLERR)) && !(events & EPOLLIN)) client.gone = true;  // both ways, and all was read
  settle(id);
}

// Reads and answers, for one turn; who leaves answers unread is not read further.
void ControlServer::work(Client& client) {
  LineReader::Line line;
  for (std::size_t steps = 0; steps < kMostStepsATurn; ++steps) {
    if (client.gone || client.output.pending() >= kPauseReading) return;
    if (client.reader.next(line))
      handle(client, line);
    else if (client.ended || !read_some(client))
      return;
  }
  loop_.post([self = self_, id = client.id] {  // the others have their turn, then it goes on
    if (*self != nullptr) (*self)->ready(id, 0);
  });
}

bool ControlServer::read_some(Client& client) {
  std::array<char, 16384> bytes;  // NOLINT(cppcoreguidelines-pro-type-member-init): written by recv
  const ssize_t got = recv(client.descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (got > 0) {
    client.reader.add({bytes.data(), static_cast<std::size_t>(got)});
    return true;
  }
  if (got == 0) client.ended = true;
  if (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) client.gone = true;
  return false;
}

void ControlServer::handle(Client& client, const LineReader::Line& line) {
  client.asked = true;
  ++counters_.requests;
  if (line.too_long)
    return refuse(client, "too_long", nullptr, fmt::format("a line has at most {} bytes", control::kMostLineBytes));
  if (line.text.find_first_not_of(" \t") == std::string::npos) return;
  const Json object = Json::parse(line.text, nullptr, false);
  if (object.is_discarded()) return refuse(client, "bad_json", nullptr, "this is no JSON");
  const auto command = find_command(commands_, object);
  if (!command) return refuse(client, "bad_request", &object, command.error().reason);
  if ((*command)->effect == Effect::changes && !client.caller.may_change)
    return refuse(client, "denied", &object,
                  fmt::format("{} changes something: only root, the daemon's user and the socket's group may, over the "
                              "Unix socket (you are {})",
                              (*command)->name, client.caller.name));
  answer(client, **command, object);
}

void ControlServer::answer(Client& client, const Command& command, const Json& object) {
  bool later_asked = false;
  const Request request{object, client.watched, [&] {
                          later_asked = true;
                          return later(client, object);
                        }};
  Result<Json> result = Error{};
  try {
    result = command.handler(request);
  } catch (...) {
    result = Error{"", what_of_current_exception()};
  }
  if (!result) {
    if (later_asked && client.waiting > 0) --client.waiting;
    return refuse(client, "failed", &object, result.error().text());
  }
  Json head = with_class(later_asked ? "ACK" : command.name, &object);
  if (later_asked) head["of"] = command.name;
  say(client, joined(std::move(head), *result));
}

void ControlServer::refuse(Client& client, const char* kind, const Json* object, const std::string& message) {
  ++counters_.errors[kind];
  Json error = with_class("ERROR", object);
  error["message"] = message;
  say(client, error);
}

Later ControlServer::later(Client& client, const Json& object) {
  ++client.waiting;
  Json head = with_class("DONE", &object);
  head["of"] = object.at("class");
  return [self = self_, &loop = loop_, id = client.id, head](Result<Json> result) {
    loop.post([self, id, head, result = std::move(result)] {
      if (*self == nullptr) return;
      ControlServer& server = **self;
      const auto found = server.clients_.find(id);
      if (found == server.clients_.end()) return;
      if (found->second->waiting > 0) --found->second->waiting;
      if (result)
        server.say(*found->second, joined(head, *result));
      else
        server.refuse(*found->second, "failed", &head, result.error().text());
      server.settle(id);
    });
  };
}

void ControlServer::say(Client& client, const Json& object) { say_line(client, control::line_of(object)); }

// One object always has room where nothing waits.
void ControlServer::say_line(Client& client, const std::string& line) {
  if (client.gone) return;
  if (client.output.pending() > 0 && client.output.pending() + line.size() > control::kMostUnread)
    return drop(client, "slow", "does not read what it asked for");
  ++counters_.sent;
  client.output.add(line);
  if (!client.output.flush(client.descriptor)) client.gone = true;
}

void ControlServer::tell(std::string_view watched, const std::function<Json()>& make) {
  std::optional<std::string> line;
  std::vector<ClientId> told;
  for (const auto& [id, client] : clients_) {
    if (!client->watched.contains(watched)) continue;
    if (!line) line = control::line_of(joined(with_class(watched, nullptr), make()));
    say_line(*client, *line);
    told.push_back(id);
  }
  for (const ClientId id : told) settle(id);
}

bool ControlServer::watches(std::string_view watched) const {
  for (const auto& [id, client] : clients_)
    if (client->watched.contains(watched)) return true;
  return false;
}

void ControlServer::drop(Client& client, const char* why, const char* words) {
  client.gone = true;
  const std::uint64_t count = ++counters_.dropped[why];
  log_.limited(std::string("control ") + why, "control client ({}) {}: dropped, {} so far", client.caller.name, words,
               count);
}

// After whatever was done with a client: closes it, or waits for what it is waited for.
void ControlServer::settle(ClientId id) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  Client& client = *found->second;
  const bool idle = client.output.pending() == 0 && client.watched.empty() && client.waiting == 0;
  if (client.gone || (client.ended && idle)) {
    loop_.forget(client.watch);
    clients_.erase(found);
    if (changed_) changed_();
    return;
  }
  if (changed_) changed_();
  std::uint32_t wanted = client.output.pending() > 0 ? EventLoop::kWritable : 0;
  if (!client.ended && client.output.pending() < kPauseReading) wanted |= EventLoop::kReadable;
  if (wanted != client.interest) loop_.change(client.watch, wanted);
  client.interest = wanted;
}

// Once a second.
void ControlServer::look() {
  for (const auto& door : doors_)
    if (std::exchange(door->paused, false)) loop_.change(door->watch, EventLoop::kReadable);
  std::vector<ClientId> all;
  for (const auto& [id, client] : clients_) {
    const bool stalls = client->output.pending() > 0 && client->output.taken() == client->taken_seen;
    client->taken_seen = client->output.taken();
    client->stalled_s = stalls ? client->stalled_s + 1 : 0;
    if (client->stalled_s < kMostStalled_s) continue;
    drop(*client, "stalled", "has read nothing for ten seconds");
    all.push_back(id);
  }
  for (const ClientId id : all) settle(id);
}

}  // namespace onemap::daemon
