// Datagrams of the right form with any content, in any order, from neighbours and others, while time goes on: no
// sequence of frames breaks a node.
#include <gtest/gtest.h>

#include <algorithm>

#include "alone_node.hpp"

namespace onemap::comms {
namespace {

using sim::Alone;
using sim::Random;

NodeConfig small_limits() {
  NodeConfig config;
  config.peers = {Endpoint::ipv4(10, 0, 0, 1, 1)};
  config.reassembly_bytes = 1u << 20;
  config.max_logs = 200, config.max_robots = 40;
  return config;
}

// Names, lives, logs and counts of which many mean something to the node and some nothing.
struct Anything {
  Random random;

  RobotId robot() {
    const char* names[] = {"self", "friend", "other", "third"};
    return random.below(3) == 0 ? sim::numbered("r", random.below(60)) : RobotId::from_name(names[random.below(4)]);
  }
  std::uint64_t life() {
    const std::uint64_t lives[] = {1, 5, 6, Alone::kLife - 1, Alone::kLife, Alone::kLife + 1, ~std::uint64_t{0}};
    return lives[random.below(7)];
  }
  LogId log() { return {robot(), static_cast<std::uint8_t>(random.below(kLaneCount)), life()}; }
  RecordId record() { return {log(), static_cast<std::uint32_t>(random.below(4))}; }
  std::uint32_t count() {
    return static_cast<std::uint32_t>(random.below(2) == 0 ? random.below(5) + 1 : random.next() | 1);
  }
  std::uint16_t u16() { return static_cast<std::uint16_t>(random.next()); }
};

class Storm {
 public:
  explicit Storm(std::uint64_t seed) : any_{Random(seed)} {}

  void round() {
    alone_.hear(sim::datagram(header(),
                              [&](wire::Encoder& out) {
                                for (std::uint64_t k = random().below(4); k < 4; ++k) frame(out);
                              }),
                Endpoint::ipv4(10, 0, 0, static_cast<std::uint8_t>(1 + random().below(5)), 1));
    if (random().below(3) == 0)
      alone_.now += std::chrono::microseconds(random().below(random().below(50) == 0 ? 9'000'000 : 9'000));
    if (random().below(4) == 0) alone_.node.on_timer(alone_.now);
    if (random().below(50) == 0)
      (void)alone_.node.append(alone_.now, static_cast<std::uint8_t>(random().below(6)), 1, body_);
    hear_answers();
    if (random().below(50) == 0) look_around();
  }
  void expect_whole() {
    std::shared_ptr<const Record> record;
    while (alone_.node.next_applied(record)) ASSERT_NE(record, nullptr);
    ASSERT_EQ(alone_.node.frontier_digest(), digest(alone_.node.frontier()));
    ASSERT_LE(alone_.node.team().size(), 40u);
    ASSERT_LE(alone_.node.frontier().size(), 200u + kLaneCount);
  }
  const Node& node() const { return alone_.node; }

 private:
  Random& random() { return any_.random; }

  wire::Header header() {
    const std::uint64_t sender = random().below(20) == 0 ? any_.life() % wire::kFirstBadIncarnation : 5;
    wire::Header header{random().below(20) == 0 ? wire::DatagramType::group : wire::DatagramType::unicast,
                        std::max<std::uint64_t>(sender, 1), random().below(20) == 0 ? random().below(90) : Alone::kLife,
                        ++counter_};
    if (random().below(200) == 0) header.counter = static_cast<std::uint32_t>(random().next() | 1);
    return header;
  }

  void frame(wire::Encoder& out) {
    switch (random().below(9)) {
      case 0:
        out.beacon({any_.robot(), random().next(), random().next(), any_.count(),
                    static_cast<std::uint8_t>(random().below(3))});
        break;
      case 1: {
        const RobotStatus status{any_.robot(), any_.life(), any_.count(), random().next(), random().next(), 1};
        out.status({&status, 1});
        break;
      }
      case 2:
      case 3: {
        const wire::HaveEntry entry{any_.log(), any_.count()};
        out.have(random().next(), {&entry, 1});
        break;
      }
      case 4:
        out.have_request();
        break;
      case 5: {
        const wire::WantEntry entry{any_.record(), any_.u16(), static_cast<std::uint16_t>(any_.u16() | 1)};
        out.want(static_cast<std::uint32_t>(random().next()), {&entry, 1});
        break;
      }
      case 6:
      case 7:
        data(out);
        break;
      default:
        random().below(2) == 0 ? out.ping(any_.count()) : out.later_life({any_.robot(), any_.life()});
    }
  }

  // Mostly of what the node asked for, mostly signed and with the right hash.
  void data(wire::Encoder& out) {
    const RecordId id =
        !asked_.empty() && random().below(8) != 0 ? asked_[random().below(asked_.size())].id : any_.record();
    const std::size_t size = random().below(9) == 0 ? random().below(3000) : id.seq * 700 % 3000;
    Record record{id, 1, {body_.begin(), body_.begin() + static_cast<std::ptrdiff_t>(size)}, {}, {}};
    if (id.seq < 300 && random().below(20) != 0) record = logs_.record(id, 1, record.body);
    if (random().below(20) == 0) {
      Record later = record;
      ++later.id.seq;
      if (id.seq < 300 && random().below(4) != 0) later = logs_.record(later.id, 1, {1});
      out.head({head_of(record), 0, record.seal.signature, {head_of(later), later.seal.signature}});
      return;
    }
    wire::FragmentBuffer scratch;
    const auto fragments = wire::fragments_of(wire::payload_bytes(record));
    wire::Data data = sim::fragment(record, static_cast<std::uint32_t>(random().below(fragments)), scratch);
    data.body_hash ^= random().below(6) == 0;
    out.data(data);
  }

  void hear_answers() {
    wire::Decoder decoder;
    for (const auto& one : alone_.sent()) {
      ASSERT_LE(one.size, kMaxDatagramBytes);
      ASSERT_EQ(decoder.decode(one.bytes()), Refusal::count);
      for (const auto& f : decoder.frames())
        if (const auto* want = std::get_if<wire::Want>(&f)) {
          if (asked_.size() > 40) asked_.clear();
          asked_.insert(asked_.end(), want->entries.begin(), want->entries.end());
        }
    }
  }

  void look_around() {
    alone_.node.records_missing();
    alone_.node.presence(alone_.now);
    alone_.node.delivered(4);
    alone_.node.neighbours();
  }

  Anything any_;
  Alone alone_{small_limits(), 300'000};
  std::vector<std::uint8_t> body_ = std::vector<std::uint8_t>(3000);
  sim::SignedLogs logs_;
  std::vector<wire::WantEntry> asked_;  // of us, lately
  std::uint32_t counter_ = 0;
};

TEST(Hostile, NoSequenceOfValidFramesBreaksANode) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Storm storm(seed);
    for (int round = 0; round < 4'000; ++round) {
      storm.round();
      storm.expect_whole();
      if (testing::Test::HasFatalFailure()) return;
    }
    for (const auto& [log_id, n] : storm.node().frontier()) {
      EXPECT_TRUE(log_id.robot != RobotId::from_name("self") || log_id.incarnation <= Alone::kLife);
      EXPECT_TRUE(wire::is_life(log_id.incarnation));
    }
    EXPECT_GT(storm.node().counters().records_received, 20u) << "the test must have got somewhere";
  }
}

}  // namespace
}  // namespace onemap::comms
