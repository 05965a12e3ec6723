#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "comms/memory_store.hpp"
#include "comms/node.hpp"
#include "comms/udp/udp_port.hpp"
#include "daemon/config.hpp"
#include "daemon/log.hpp"
#include "daemon/outgoing.hpp"

namespace onemap::daemon {

struct RadioView {
  std::uint64_t frontier_digest = 0;
  std::uint64_t robots_heard = 1;      // ever, this one included
  std::uint64_t neighbours_heard = 0;  // ever
  std::uint64_t records_missing = 0;
  bool agrees = false;              // all robots heard of are finished and say one map and one record set,
  std::uint64_t agreed_digest = 0;  // this map
  std::uint64_t bytes_sent = 0, bytes_received = 0;
};

// The radio thread: the protocol's node on a UDP socket. Others hand it records and this robot's status.
class Radio {
 public:
  using Applied = std::function<void(std::shared_ptr<const Record>)>;
  static Result<std::unique_ptr<Radio>> open(const Config& config, Applied applied, Log& log);
  ~Radio();
  Radio(const Radio&) = delete;
  Radio& operator=(const Radio&) = delete;

  void start();
  void stop();
  void publish(OutgoingRecord record);                // any thread
  void say(std::uint64_t map_digest, bool finished);  // any thread: what neighbours and beacons hear
  RadioView view() const;
  std::string local() const { return comms::to_string(port_->local()); }

 private:
  Radio(const Config& config, comms::NodeConfig node, std::unique_ptr<comms::UdpPort> port, Applied applied, Log& log);
  void run();
  void turn();
  void receive_some();
  void append_published(Instant now);
  void log_neighbours();
  void update_view();
  Log& log_;
  Applied applied_;
  comms::MemoryStore store_;
  std::unique_ptr<comms::UdpPort> port_;
  comms::Node node_;
  mutable std::mutex mutex_;
  std::vector<OutgoingRecord> outbox_;
  std::uint64_t map_digest_ = 0;
  std::uint8_t flags_ = 0;
  std::uint64_t said_digest_ = 0;  // as the node has it
  RadioView view_;
  std::map<RobotId, bool> alive_;  // as last logged
  Instant looked_{};
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace onemap::daemon
