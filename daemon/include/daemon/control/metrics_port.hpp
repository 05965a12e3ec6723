#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "daemon/control/listener.hpp"
#include "daemon/control/output_buffer.hpp"
#include "daemon/event_loop.hpp"
#include "daemon/log.hpp"

namespace onemap::daemon {

// What a Prometheus server asks for over HTTP, and nothing else: GET /metrics. One request a connection, of at most
// 4 KiB, within ten seconds; sixteen connections at once. Nothing waits; all on the loop's thread.
class MetricsPort {
 public:
  static Result<std::unique_ptr<MetricsPort>> open(EventLoop& loop, Listener listener,
                                                   std::function<std::string()> text, Log& log);
  ~MetricsPort();
  MetricsPort(const MetricsPort&) = delete;
  MetricsPort& operator=(const MetricsPort&) = delete;

 private:
  struct Visitor;
  MetricsPort(EventLoop& loop, Listener listener, std::function<std::string()> text, Log& log);
  void accept_some();
  void admit(int descriptor);
  void ready(int descriptor);
  bool read_some(Visitor& visitor);
  void look();

  EventLoop& loop_;
  Listener listener_;
  const std::function<std::string()> text_;
  Log& log_;
  EventLoop::Id watch_ = 0, timer_ = 0;
  bool paused_ = false;
  std::map<int, std::unique_ptr<Visitor>> visitors_;
};

// The whole answer to a request as far as its empty line: 200 with text(), or 400, 404, 405.
std::string http_answer(const std::string& request, const std::function<std::string()>& text);

}  // namespace onemap::daemon
