#pragma once
#include <string>

#include "control/line_reader.hpp"
#include "control/protocol.hpp"
#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::control {

// A program's side of a daemon's control socket; it waits, but not for ever.
class ControlClient {
 public:
  // Connects and hears the greeting. The error names the path, what is wrong with it, and what to do.
  static Result<ControlClient> connect(const std::string& path, Duration patience);
  ControlClient(ControlClient&& other) noexcept;
  ControlClient& operator=(ControlClient&&) = delete;
  ~ControlClient();

  const Json& greeting() const { return greeting_; }
  Status send(const Json& request);
  Result<Json> receive(Duration patience);  // the next object
  // Asks, and hears the answer, over an ACK and whatever comes in between. An ERROR is this one's error.
  Result<Json> ask(Json request, Duration patience);

 private:
  ControlClient(int socket, std::string path) : socket_(socket), path_(std::move(path)) {}
  Status read_some(Duration patience);

  int socket_ = -1;
  std::string path_;
  LineReader reader_{kMostAnswerBytes};
  Json greeting_;
  int last_id_ = 0;
};

// Why nobody answers at a path, and what to do: there is nothing, it is no socket, it may not be used, nobody listens.
std::string why_no_daemon(const std::string& path, int error);

}  // namespace onemap::control
