// A proved neighbour that means no good: what it may cost is bounded, in numbers.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>

#include "alone_node.hpp"
#include "comms/frontier.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using sim::Alone;
using sim::greeting;
using sim::kStranger;

// Bytes that malloc has given out; 0 where a sanitizer answers instead of glibc.
std::size_t in_use() { return mallinfo2().uordblks; }
bool measurable() {
  const std::size_t before = in_use();
  const std::vector<char> some(10'000);
  return in_use() >= before + some.size();
}

void expect_grown_at_most(std::size_t bytes, std::size_t before) {
  if (measurable()) {
    EXPECT_LE(in_use(), before + bytes) << "grown by " << in_use() - before;
  }
}

// Speaks the protocol as a neighbour, with whatever content.
struct Evil {
  Alone& alone;
  std::uint64_t life = 5;
  Endpoint at = kStranger;
  std::uint32_t counter = 1;
  std::size_t served = 0;
  std::vector<std::uint8_t> body{};
  VersionVector offered{};
  sim::SignedLogs logs{};

  void befriend(const std::string& name) { alone.befriend(name, life, at); }
  template <class Write>
  void say(Write write) {
    alone.hear_frames(life, ++counter, write, at);
  }
  // Whatever it says, its digest fits to it.
  void offer(const std::vector<wire::HaveEntry>& entries) {
    for (const wire::HaveEntry& entry : entries) offered[entry.log] = std::max(offered[entry.log], entry.count);
    for (std::size_t k = 0; k < entries.size(); k += 30)
      say([&](auto& out) {
        out.have(digest(offered), std::span(entries).subspan(k, std::min<std::size_t>(30, entries.size() - k)));
      });
  }
  // Answers everything that is asked of it, until nothing is asked any more.
  void serve(std::uint64_t hash_error = 0) {
    wire::Decoder decoder;
    for (int round = 0; round < 3000; ++round) {
      const auto datagrams = alone.sent();
      const std::size_t before = served;
      for (const auto& one : datagrams) {
        if (one.to != at || decoder.decode(one.bytes()) != Refusal::count) continue;
        for (const auto& frame : decoder.frames())
          if (const auto* want = std::get_if<wire::Want>(&frame))
            for (const auto& entry : want->entries) serve_one(entry, hash_error);
      }
      if (served == before) return;
      alone.now += 1ms;
    }
  }
  void serve_one(const wire::WantEntry& entry, std::uint64_t hash_error) {
    const Record record = logs.record(entry.id, 0, body);
    const std::uint32_t fragments = wire::fragments_of(wire::payload_bytes(record));
    for (std::uint32_t f = entry.first; f < std::min<std::uint32_t>(entry.first + entry.count, fragments); ++f) {
      wire::FragmentBuffer scratch;
      wire::Data data = sim::fragment(record, f, scratch);
      data.body_hash ^= hash_error;
      say([&](auto& out) { out.data(data); });
      ++served;
    }
  }
};

TEST(Hostile, LogsOfManyRobotsAreBounded) {
  Alone alone({}, 64u << 20);
  Evil evil{alone};
  evil.befriend("evil");
  const std::size_t before = in_use();
  for (std::size_t round = 0; round < 3; ++round) {
    std::vector<wire::HaveEntry> entries;
    for (std::size_t k = 0; k < 4000; ++k) entries.push_back({{sim::numbered("r", 4000 * round + k), 0, 1}, 1});
    evil.offer(entries);
    evil.serve();
  }
  EXPECT_LE(alone.node.frontier().size(), 1024u - 32);
  EXPECT_GT(alone.node.frontier().size(), 900u) << "the test must have shown them";
  EXPECT_LE(alone.node.team().size(), 1024u);
  EXPECT_GT(alone.node.counters().of(Refusal::robots_full), 5000u);
  expect_grown_at_most(4u << 20, before);
  // A newcomer that greets is heard all the same: places are kept for neighbours.
  Evil newcomer{alone, 3, Endpoint::ipv4(10, 0, 0, 3, 1)};
  newcomer.befriend("newcomer");
  newcomer.offer({{{RobotId::from_name("newcomer"), 0, 3}, 1}});
  newcomer.serve();
  EXPECT_TRUE(alone.node.frontier().contains({RobotId::from_name("newcomer"), 0, 3}));
}

TEST(Hostile, LogsInOneNameAreBounded) {
  Alone alone({}, 64u << 20);
  Evil evil{alone, 100'000};
  evil.befriend("evil");
  for (std::uint64_t life = 1; life <= 3500; life += 100) {
    std::vector<wire::HaveEntry> entries;
    for (std::uint64_t k = life; k < life + 100; ++k) {
      entries.push_back({{RobotId::from_name("evil"), 0, k}, 1});
      for (std::uint8_t lane = 0; lane < kLaneCount; ++lane)
        entries.push_back({{RobotId::from_name("self"), lane, 1 + k % (Alone::kLife - 1)}, 1});
    }
    evil.offer(entries);
    evil.serve();
  }
  EXPECT_LE(alone.node.frontier().size(), 512u);
  EXPECT_GT(alone.node.frontier().size(), 500u);
  EXPECT_GT(alone.node.counters().of(Refusal::robot_logs_full), 3000u);
  // What it writes in the life in which it greets is taken even then.
  evil.offer({{{RobotId::from_name("evil"), 0, 100'000}, 1}});
  evil.serve();
  EXPECT_TRUE(alone.node.frontier().contains({RobotId::from_name("evil"), 0, 100'000}));
}

// Of what many neighbours say that they hold so much is kept as leaves the room that records need; what only one of
// them has is believed all the same.
TEST(Hostile, ClaimsOfAllNeighboursAreBounded) {
  Alone alone({}, 64u << 20);
  const auto claim = [&](std::uint8_t who, std::size_t first, std::size_t count) {
    Evil evil{alone, 5, Endpoint::ipv4(10, 0, 0, who, 1)};
    evil.befriend("evil" + std::to_string(who));
    std::vector<wire::HaveEntry> entries;
    for (std::size_t i = first; i < first + count; ++i) entries.push_back({{sim::numbered("r", i), 0, 1}, 1});
    evil.offer(entries);
  };
  for (std::uint8_t k = 0; k < 20; ++k) claim(k, 0, 900);
  EXPECT_EQ(alone.node.counters().of(Refusal::logs_full), 20u * 900 - 16'384);
  EXPECT_EQ(alone.node.records_missing(), 900u);
  claim(21, 900, 50);
  EXPECT_EQ(alone.node.records_missing(), 950u) << "it alone has them";
  const MemoryView memory = alone.node.memory_view();
  EXPECT_EQ(memory.spilled, 0u);
  EXPECT_LE(memory.most_used, memory.capacity - NodeConfig().reassembly_bytes);
}

TEST(Hostile, LogsThatOneNeighbourClaimsAreBounded) {
  NodeConfig config;
  config.max_logs = 50;
  Alone alone(config, 64u << 20);
  Evil evil{alone};
  evil.befriend("evil");
  std::vector<wire::HaveEntry> entries;
  for (std::size_t k = 0; k < 200; ++k) entries.push_back({{sim::numbered("r", k), 0, 1}, 1});
  evil.offer(entries);
  EXPECT_EQ(alone.node.records_missing(), 50u);
  EXPECT_EQ(alone.node.counters().of(Refusal::logs_full), 150u);
  // And so are those that are held, whoever else brings more.
  evil.serve();
  EXPECT_EQ(alone.node.frontier().size(), 50u);
  Evil other{alone, 6, Endpoint::ipv4(10, 0, 0, 6, 1)};
  other.befriend("other");
  other.offer({entries.begin() + 100, entries.end()});
  other.serve();
  EXPECT_EQ(alone.node.frontier().size(), 50u);
}

// HAVE with counts that nobody can hold: bounded memory, and an honest neighbour's records come as before.
TEST(Hostile, LiesAboutCountsKeepHonestRecordsComing) {
  Alone alone({}, 64u << 20);
  Evil evil{alone};
  evil.befriend("evil");
  const std::size_t before = in_use();
  std::vector<wire::HaveEntry> entries;
  for (std::size_t k = 0; k < 4096; ++k)
    entries.push_back({{sim::numbered("liar", k), static_cast<std::uint8_t>(k % 5), 1}, 0xFFFFFFFF});
  evil.offer(entries);
  Evil honest{alone, 3, Endpoint::ipv4(10, 0, 0, 3, 1)};
  honest.body.assign(30'000, 7);
  honest.befriend("honest");
  std::vector<wire::HaveEntry> good;
  for (std::uint8_t lane = 0; lane < kLaneCount; ++lane) good.push_back({{RobotId::from_name("honest"), lane, 3}, 10});
  honest.offer(good);
  for (int k = 0; k < 300; ++k) {
    honest.serve();
    alone.now += 20ms;
    alone.node.on_timer(alone.now);
  }
  for (const auto& entry : good) EXPECT_EQ(alone.node.frontier().at(entry.log), 10u);
  EXPECT_GT(alone.node.records_missing(), 0xFFFFFFFFu) << "it said so";
  EXPECT_TRUE(alone.node.incomplete().contains(sim::numbered("liar", 1)));
  EXPECT_FALSE(alone.node.incomplete().contains(RobotId::from_name("honest")));
  expect_grown_at_most(24u << 20, before);
}

// It begins large records and never ends them.
TEST(Hostile, RecordsThatAreNeverCompleteKeepHonestOnesComing) {
  Alone alone({}, 64u << 20);
  Evil evil{alone};
  evil.befriend("evil");
  std::vector<wire::HaveEntry> entries;
  for (std::size_t k = 0; k < 100; ++k) entries.push_back({{sim::numbered("big", k), 3, 1}, 100});
  evil.offer(entries);
  evil.body.assign(kMaxRecordBytes, 1);
  wire::Decoder decoder;
  const auto first_fragments = [&] {
    for (const auto& one : alone.sent()) {
      if (one.to != evil.at || decoder.decode(one.bytes()) != Refusal::count) continue;
      for (const auto& frame : decoder.frames())
        if (const auto* want = std::get_if<wire::Want>(&frame))
          for (const auto& entry : want->entries) evil.serve_one({entry.id, entry.first, 1}, 0);
    }
  };
  for (int k = 0; k < 100; ++k) {
    first_fragments();
    alone.now += 20ms;
    alone.node.on_timer(alone.now);
  }
  Evil honest{alone, 3, Endpoint::ipv4(10, 0, 0, 3, 1)};
  honest.body.assign(200'000, 7);
  honest.befriend("honest");
  const LogId log{RobotId::from_name("honest"), 3, 3};
  honest.offer({{log, 5}});
  for (int k = 0; k < 500; ++k) {
    honest.serve();
    first_fragments();
    alone.now += 20ms;
    alone.node.on_timer(alone.now);
  }
  const auto held = alone.node.frontier().find(log);
  ASSERT_NE(held, alone.node.frontier().end());
  EXPECT_EQ(held->second, 5u);
}

TEST(Hostile, SpoiltBodiesAreAskedForLessAndLess) {
  Alone alone({}, 64u << 20);
  Evil evil{alone};
  evil.befriend("evil");
  evil.body.assign(100'000, 3);
  evil.offer({{{RobotId::from_name("evil"), 1, 5}, 1}});
  for (int k = 0; k < 3000; ++k) {  // half a minute
    evil.serve(1);
    alone.now += 10ms;
    alone.node.on_timer(alone.now);
  }
  EXPECT_GE(alone.node.counters().of(Refusal::data_bad_hash), 3u);
  EXPECT_LE(alone.node.counters().of(Refusal::data_bad_hash), 8u);
  EXPECT_TRUE(alone.node.frontier().empty());
  alone.now += 70s;
  alone.befriend("evil", 5);
  for (int k = 0; k < 100; ++k) {
    evil.say([&](auto& out) { out.have(1, {}); });
    evil.offer({{{RobotId::from_name("evil"), 1, 5}, 1}});
    alone.node.on_timer(alone.now);
    evil.serve(0);
    alone.now += 1s;
  }
  EXPECT_EQ(alone.node.frontier().size(), 1u) << "and taken when it is whole";
}

TEST(Hostile, RefusedLogsAreNotRequestedAgainAndAgain) {
  Alone alone;
  Evil evil{alone};
  evil.befriend("evil");
  for (int k = 0; k < 200; ++k) {  // ten seconds
    evil.offer({{{RobotId::from_name("self"), 0, 1000}, 1}});
    alone.sent_within(50ms);
  }
  EXPECT_GE(alone.node.counters().sent(FrameType::have_request), 2u);
  EXPECT_LE(alone.node.counters().sent(FrameType::have_request), 4u);
}

TEST(Hostile, GhostsInStatusLeaveNoTrace) {
  Alone alone;
  Evil evil{alone};
  evil.befriend("evil");
  std::vector<RobotStatus> ghosts;
  for (std::size_t k = 0; k < 20; ++k) ghosts.push_back({sim::numbered("ghost", k), 5, 1, 0, 0, 0});
  evil.say([&](auto& out) { EXPECT_EQ(out.status(ghosts), 20u); });
  EXPECT_EQ(alone.node.team().size(), 2u);
  EXPECT_EQ(alone.node.presence(alone.now).size(), 2u);
  EXPECT_EQ(alone.node.counters().of(Refusal::status_unknown), 20u);
}

// Words in our mouth: our counter is raised above them at once, so that ours are the newest again.
TEST(Hostile, AForgedStatusOfOursIsOutdoneByOurNext) {
  Alone alone;
  Evil evil{alone};
  evil.befriend("evil");
  const RobotStatus forged{RobotId::from_name("self"), Alone::kLife, 1'000'000, 1, 2, 1};
  evil.say([&](auto& out) { out.status({&forged, 1}); });
  const auto beacon = sim::first<wire::Beacon>(alone.sent_within(200ms));
  ASSERT_TRUE(beacon);
  EXPECT_EQ(beacon->second.status_counter, 1'000'001u);
  EXPECT_EQ(beacon->second.flags, 0);
}

// And about another robot: it hears of it from its neighbours, and outdoes it.
TEST(Hostile, AForgedStatusOfAnotherIsOutdoneByIt) {
  sim::SimNet net(41, {});
  net.add_team(3, sim::line(3));
  for (std::size_t i = 0; i < 3; ++i) net.append(i, 0, 50);
  ASSERT_TRUE(net.run_until([&] { return sim::agrees(net.node(0), 3, 0) && sim::agrees(net.node(2), 3, 0); }, 20s));
  const Endpoint evil = Endpoint::ipv4(10, 9, 9, 9, 1);
  net.inject(2, evil, greeting("evil", 5, 1, 1));
  const RobotStatus forged{sim::numbered("robot", 0), 1, 5'000'000, 1, 2, 0};
  net.inject(2, evil, sim::datagram({wire::DatagramType::unicast, 5, 1, 2}, [&](auto& out) {
               out.status({&forged, 1});
             }));
  EXPECT_EQ(net.node(2).team().at(forged.robot).counter, 5'000'000u);
  ASSERT_TRUE(net.run_until([&] { return net.node(2).team().at(forged.robot).counter > 5'000'000u; }, 20s));
  EXPECT_EQ(net.node(2).team().at(forged.robot).frontier_digest, net.node(0).frontier_digest());
}

TEST(Hostile, PingsAndRequestsAreAnsweredWithinBounds) {
  Alone alone({}, 64u << 20);
  Evil evil{alone};
  evil.befriend("evil");
  std::vector<RecordId> ids;
  for (int k = 0; k < 10; ++k)
    ids.push_back(alone.node.append(alone.now, 3, 1, std::vector<std::uint8_t>(kMaxRecordBytes)).value());
  alone.sent();
  const std::size_t before = in_use();
  std::vector<wire::WantEntry> wants;
  for (std::uint16_t k = 0; k < 30; ++k)
    wants.push_back({ids[k % 10], static_cast<std::uint16_t>(k * 31), static_cast<std::uint16_t>(65535 - k)});
  for (std::uint32_t k = 0; k < 10'000; ++k)
    evil.say([&](auto& out) {
      out.ping(k);
      out.want(0xFFFFFFFF, wants);
      out.have_request();
    });
  expect_grown_at_most(1u << 20, before);
  std::size_t bytes = 0;
  for (const auto& one : alone.sent_within(1s)) bytes += one.size;
  EXPECT_LT(bytes, 4'200'000u) << "the pace of bodies is kept";
  EXPECT_LE(alone.node.counters().sent(FrameType::pong), 1u);
  EXPECT_GT(alone.node.counters().of(Refusal::want_over_credit), 0u);
}

}  // namespace
}  // namespace onemap::comms
