#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "control/line_reader.hpp"
#include "daemon/control/command.hpp"
#include "daemon/control/listener.hpp"
#include "daemon/control/output_buffer.hpp"
#include "daemon/event_loop.hpp"
#include "daemon/log.hpp"

namespace onemap::daemon {

// Everything that the server counts; only ever grows.
struct ControlCounters {
  std::uint64_t accepted = 0, requests = 0, sent = 0;  // clients; lines from them; objects to them
  std::map<std::string, std::uint64_t> dropped;        // clients: slow, stalled, crowded_out, too_many, no_descriptors
  std::map<std::string, std::uint64_t> errors;         // requests: too_long, bad_json, bad_request, denied, failed
};

// Talks to any number of clients, of which none can make the others or the daemon wait: nothing blocks; a line is
// bounded; who does not read is read no further; who does not read what he asked to hear is dropped, and so is who
// takes nothing at all for ten seconds. Where all places are taken, one who never asked anything makes room. All
// on the loop's thread.
class ControlServer {
 public:
  // greeting: what a client hears first. The loop and the log must outlive the server.
  ControlServer(EventLoop& loop, std::vector<Command> commands, const Json& greeting, Log& log);
  ~ControlServer();
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

  Status serve(Listener listener);  // one or several
  // To all clients that watch objects of this class. make() is called when there is one.
  void tell(std::string_view watched, const std::function<Json()>& make);
  bool watches(std::string_view watched) const;
  void on_change(std::function<void()> told) { changed_ = std::move(told); }  // of what is watched, perhaps
  std::size_t clients() const { return clients_.size(); }
  const ControlCounters& counters() const { return counters_; }

 private:
  struct Client;
  struct Door {
    Listener listener;
    EventLoop::Id watch = 0;
    bool paused = false;
  };
  using ClientId = std::uint64_t;

  void accept_some(Door& door);
  void admit(int descriptor, const Door& door);
  bool make_room();
  void ready(ClientId id, std::uint32_t events);
  void work(Client& client);
  bool read_some(Client& client);
  void handle(Client& client, const control::LineReader::Line& line);
  void answer(Client& client, const Command& command, const Json& object);
  void refuse(Client& client, const char* kind, const Json* object, const std::string& message);
  Later later(Client& client, const Json& object);
  void say(Client& client, const Json& object);
  void say_line(Client& client, const std::string& line);
  void drop(Client& client, const char* why, const char* words);
  void settle(ClientId id);
  void look();

  EventLoop& loop_;
  const std::vector<Command> commands_;
  const std::string greeting_;
  Log& log_;
  std::vector<std::unique_ptr<Door>> doors_;
  std::map<ClientId, std::unique_ptr<Client>> clients_;
  ClientId last_ = 0;
  std::uint64_t seconds_ = 0;  // looks
  EventLoop::Id timer_ = 0;
  ControlCounters counters_;
  std::function<void()> changed_;
  std::shared_ptr<ControlServer*> self_;  // what late answers find, or nullptr
};

}  // namespace onemap::daemon
