#pragma once
#include <array>
#include <atomic>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "comms/disk/disk_store.hpp"
#include "comms/disk/posix_disk.hpp"
#include "comms/memory_store.hpp"
#include "comms/node.hpp"
#include "comms/udp/udp_port.hpp"
#include "daemon/between_turns.hpp"
#include "daemon/config.hpp"
#include "daemon/heartbeat.hpp"
#include "daemon/life.hpp"
#include "daemon/log.hpp"
#include "daemon/outgoing.hpp"
#include "daemon/team_seal.hpp"
#include "daemon/worker.hpp"
#include "hal/base/bounded_queue.hpp"
#include "mapping/team/spare_records.hpp"

namespace onemap::daemon {

// Records of one author, by kind; index 0: of a kind that this version does not know.
struct RecordTally {
  static constexpr std::size_t kKinds = 10;
  std::array<std::uint64_t, kKinds> records{}, bytes{};  // bytes of bodies
};

struct RadioView {
  std::uint64_t life = 0;  // this robot's number of it
  std::uint64_t frontier_digest = 0;
  std::uint64_t robots_heard = 1;      // with records or as living neighbours, this one included
  std::uint64_t neighbours_heard = 0;  // ever
  std::uint64_t records_missing = 0;
  bool agrees = false;              // all robots that count are finished and say one map and one record set,
  std::uint64_t agreed_digest = 0;  // this map
  std::uint64_t bytes_sent = 0, bytes_received = 0;
  std::vector<std::string> peers_never_heard;    // configured ones
  std::string id_also_used_at;                   // by somebody else, lately; empty: nowhere
  std::map<std::string, std::uint64_t> refused;  // datagrams and records, by reason; reasons that occurred
  std::map<RobotId, Instant> last_sign;          // of life, of every robot that counts
  std::map<RobotId, std::uint64_t> map_digests;  // that the others say, who count; 0: none yet
  std::set<RobotId> records_complete;            // robots of whom every record that is known of is here
  std::uint64_t needless_named = 0, let_go = 0;  // own records that later ones replace; bodies that were given up
  std::uint64_t left_out = 0;                    // own records that the store refused: the map is without them
  std::string store_full;                        // why records cannot be held, in words; empty: they can
  bool delivered = true;                         // neighbours hold this robot's control and pose records
  std::vector<comms::NeighbourStatus> neighbours;
  comms::ScalarsView scalars;              // what the team agrees on
  comms::MemoryView memory;                // of the exchange, its store aside
  comms::Counters counters;                // of this robot's present life
  std::map<RobotId, RecordTally> records;  // by author, as they were applied
};

// The radio thread: the protocol's node on a UDP socket, or with nobody to hear when the robot is alone. Others hand it
// records and this robot's status.
class Radio {
 public:
  struct Listener {
    std::function<void(std::shared_ptr<const Record>)> applied;  // each record once, own and others'
    std::function<bool()> has_room;                              // for one more; until then they wait in the store
    // This robot goes on under this number; repeats: and its records come again.
    std::function<void(std::uint64_t incarnation, bool repeats)> new_life;
  };
  static Result<std::unique_ptr<Radio>> open(const Config& config, Listener listener, Failures& failures, Log& log);
  ~Radio();
  Radio(const Radio&) = delete;
  Radio& operator=(const Radio&) = delete;

  void start();
  // Sends what was published, until neighbours hold this robot's control and pose records, for at most `linger`.
  void stop(Duration linger = Duration::zero());
  void publish(OutgoingRecord record);  // any thread but this one; waits while 64 are on their way
  void finish(std::uint32_t frames);    // any thread: nothing more of the own camera comes
  // Any thread: waits until what was published and finished before is on the disk and was handed to the listener; for
  // this long at most. False: it is not.
  bool settle(Duration most);
  void bring_brightness(double mean) { brightness_ = mean; }  // of the camera's images, for the team's talks
  void say(std::uint64_t map_digest, bool finished);          // any thread: what neighbours and beacons hear
  void spare(mapping::SpareRecords records);                  // any thread: own ones are named, unread ones let go
  void leave_out(std::set<RobotId> gone);                     // any thread: agreement does not wait for these
  // Any thread but the radio's: calls question(node, store) there, between two turns, and waits. It must be quick: the
  // network waits. False: it was not called and never will be; `stop` was set, or the radio has ended.
  using Question = std::function<void(comms::Node&, comms::LogStore&)>;
  bool ask(const Question& question, const std::atomic<bool>& stop);
  const comms::DiskStore* kept() const { return store_.kept; }  // what is kept on the disk; nullptr: nothing
  RadioView view() const;
  const Heartbeat& heartbeat() const { return heartbeat_; }
  std::uint64_t incarnation() const { return life_.number(); }  // before start()
  std::string local() const { return comms::to_string(port_->local()); }

 private:
  static constexpr std::size_t kOutbox = 64;
  struct Store {  // on the disk, if it can be
    std::unique_ptr<comms::PosixDisk> disk;
    std::unique_ptr<comms::LogStore> log;
    comms::DiskStore* kept = nullptr;  // the log, when it is on the disk
  };
  static Store open_store(const Config& config, Log& log);
  Radio(const Config& config, Store store, comms::NodeConfig node, LifeCounter life,
        std::unique_ptr<comms::DatagramPort> port, std::unique_ptr<TeamSeal> seal, Listener listener,
        Failures& failures, Log& log);
  void begin_node();
  void on_timer(Instant now);
  Instant next_deadline() const;
  bool next_outgoing(comms::OutgoingDatagram& datagram);
  comms::Counters counters() const;
  void log_guard();
  void run();
  bool over(Instant now);
  void turn();
  void receive_some();
  void receive(const comms::IncomingDatagram& datagram);
  void append_published(Instant now);
  void append(Instant now, OutgoingRecord record);
  Result<RecordId> append_body(Instant now, OutgoingRecord& record);
  std::size_t may_wait() const;
  void name_needless(Instant now, std::size_t leave);
  void take_spare();
  void replace_keyframes(Instant now);
  bool append_finished(Instant now, std::uint32_t frames);
  void begin_new_life(Instant now);
  void end_life(Instant now, OutgoingRecord hello);
  void rise_again();
  bool hand_out_applied();
  void hand_out(std::shared_ptr<const Record> record);
  void log_complaints();
  void log_neighbours();
  void log_refusals();
  void log_network();
  void log_disk();
  comms::DiskFault disk_fault() const;  // of the log, now
  void log_conflict(Instant now);
  void update_view(Instant now);

  const Config& config_;
  Failures& failures_;
  Log& log_;
  Listener listener_;
  LifeCounter life_;
  unsigned new_lives_ = 0;
  comms::NodeConfig node_config_;
  Store store_;
  std::unique_ptr<comms::DatagramPort> port_;
  const std::unique_ptr<TeamSeal> seal_;  // nullptr: no team key, and no guard
  std::unique_ptr<comms::Node> node_;
  std::unique_ptr<comms::Guard> guard_;  // between the node and the port
  std::uint64_t not_loopback_ = 0;       // datagrams from other machines, though there is no team key
  Published published_;
  std::uint64_t sent_before_ = 0, received_before_ = 0;  // bytes, by the nodes of this robot's lives before
  std::optional<std::uint32_t> frames_to_finish_;        // Finished is due, with these frames
  bool work_over_ = false;                               // this robot maps no more
  Instant finish_again_{};

  BlockingQueue<OutgoingRecord> outbox_{kOutbox};
  BetweenTurns asked_{[this] { port_->wake(); }};
  std::atomic<std::uint64_t> handed_in_ = 0, settled_ = 0;  // so often was something published, and of these settled
  mutable std::mutex mutex_;                                // of what follows
  std::optional<std::uint32_t> finish_;
  std::uint64_t map_digest_ = 0;
  std::uint8_t flags_ = 0;
  std::set<RobotId> gone_;
  mapping::SpareRecords spare_;
  RadioView view_;

  std::deque<RecordId> needless_;                 // own voxel records, to be named
  std::deque<mapping::KeyframeRemains> remains_;  // of own keyframes, to be written
  std::uint64_t named_ = 0, let_go_ = 0;          // of these; bodies that were given up

  std::uint64_t said_digest_ = 0;           // as the node has it
  std::map<RobotId, bool> alive_;           // as last logged
  std::map<RobotId, RecordTally> records_;  // of robots that the store holds
  std::array<std::uint64_t, comms::kRefusalCount> logged_refusals_{};
  std::uint64_t sends_ = 0, sends_failed_ = 0, failed_before_ = 0;  // datagrams; since the last look; before it
  bool cut_off_ = false;                                            // nothing could be sent, as last logged
  comms::DiskFault disk_fault_ = comms::DiskFault::none;            // of the log, as last logged
  Instant looked_{};
  std::atomic<bool> stopping_ = false;
  std::atomic<double> brightness_ = 0.0;  // 0: not known
  std::atomic<std::int64_t> linger_until_ns_ = 0;
  Heartbeat heartbeat_;
  Worker thread_;
};

}  // namespace onemap::daemon
