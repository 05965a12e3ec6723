#pragma once
// Network namespaces of this process with emulated links between them, for real programs: each link is two TUN devices
// whose packets pass through a LinkModel in real time. Nothing has a name outside this process and nothing is left
// behind.
#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <queue>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "hal/base/result.hpp"
#include "support/link_model.hpp"

namespace onemap::test {

class EmulatedNet {
 public:
  struct Link {
    std::size_t a = 0, b = 0;  // namespaces
    LinkTraits there, back;    // from a to b, and from b to a
  };
  // The error says what is missing: namespaces (root is needed) or /dev/net/tun.
  static Result<std::unique_ptr<EmulatedNet>> open(std::size_t namespaces, const std::vector<Link>& links,
                                                   std::uint64_t seed);
  ~EmulatedNet();
  EmulatedNet(const EmulatedNet&) = delete;
  EmulatedNet& operator=(const EmulatedNet&) = delete;

  // The address of this namespace on this link; it must be one of the link's two.
  std::string address(std::size_t link, std::size_t of) const;
  // Runs `body` on a thread that is in this namespace (sockets made there stay there), and waits for it.
  void in(std::size_t net, const std::function<void()>& body) const;
  // Starts a program there, its standard output to `output` (-1: ours). The child ends with this process. -1: failed.
  pid_t start(std::size_t net, const std::vector<std::string>& command, int output = -1) const;

  void set(std::size_t link, const LinkTraits& there, const LinkTraits& back);
  void set_up(std::size_t link, bool up);  // down: nothing passes
  LinkCount count(std::size_t link, bool back = false) const;
  void keep_queues(std::size_t link);
  std::vector<Duration> queues(std::size_t link, bool back = false) const;

 private:
  struct End;   // of a link: a TUN device
  struct Late;  // a packet on its way
  EmulatedNet();
  void run();
  void receive(std::size_t end);
  Status open_end(const Link& link, std::size_t number, bool second);

  std::vector<int> namespaces_;
  std::vector<Link> links_;
  std::vector<End> ends_;                           // 2 * link: in its first namespace
  std::vector<std::unique_ptr<LinkModel>> models_;  // from that end to the other
  mutable std::mutex mutex_;                        // of the models
  std::vector<Late> late_;                          // a heap by time
  std::uint64_t order_ = 0;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace onemap::test
