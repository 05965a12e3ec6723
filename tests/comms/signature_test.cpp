// Who wrote a record: what is signed, what is refused, and who is named for it.
#include <gtest/gtest.h>

#include "alone_node.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using sim::Alone;
using sim::SignedLogs;

const RobotId kFriend = RobotId::from_name("friend"), kStranger = RobotId::from_name("other");
const LogId kPoses{kFriend, 1, 5};

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string out;
  for (const auto byte : bytes)
    for (const int shift : {4, 0}) out += "0123456789abcdef"[(byte >> shift) & 15];
  return out;
}

// The bytes of PROTOCOL.md, written down by hand.
TEST(Signature, GoldenHead) {
  Record record{{{RobotId::from_name("robot1"), 3, 0x0102030405060708u}, 5}, 0x0204, {1, 2, 3}, {}, {}};
  record.seal.previous.fill(0xC0);
  record.seal.replaces = 0x01020304;
  std::string previous;
  for (int k = 0; k < 32; ++k) previous += "c0";
  const std::string body = hex(digest_of(record.body));
  EXPECT_EQ(hex(signed_bytes(head_of(record))),
            "6f6e656d6170207265636f7264203200"  // "onemap record 2"
            "726f626f743100000000000000000000"  // robot1
            "03"
            "0807060504030201"
            "05000000"  // lane, incarnation, sequence
            "0402"
            "03000000" +
                body + previous + "04030201");
  // BLAKE2b-256 of nothing, as published.
  EXPECT_EQ(hex(digest_of({})), "0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8");
}

TEST(Signature, HoldsForTheRecordAndNothingElse) {
  SignedLogs logs;
  const Record first = logs.next(kPoses, 3, {7, 8}), second = logs.next(kPoses, 3, {9});
  const PublicKey key = sim::identity_of(kFriend).public_key();
  EXPECT_EQ(first.seal.previous, key);
  EXPECT_EQ(second.seal.previous, hash_of(head_of(first)));
  EXPECT_TRUE(signed_by(key, head_of(second), second.seal.signature));
  EXPECT_TRUE(signed_by(key, head_of(without_body(second)), second.seal.signature)) << "the body may go";
  EXPECT_FALSE(signed_by(sim::identity_of(kStranger).public_key(), head_of(second), second.seal.signature));
  for (int change = 0; change < 8; ++change) {
    Record other = second;
    if (change == 0) other.id.seq ^= 1;
    if (change == 1) other.id.log.lane ^= 1;
    if (change == 2) other.id.log.incarnation ^= 1;
    if (change == 3) other.kind ^= 1;
    if (change == 4) other.body[0] ^= 1;
    if (change == 5) other.seal.previous[3] ^= 1;
    if (change == 6) other.id.log.robot = kStranger;
    if (change == 7) other.seal.replaces = 0;
    EXPECT_FALSE(signed_by(key, head_of(other), second.seal.signature)) << change;
  }
}

TEST(Signature, WithoutAKeyNothingIsWritten) {
  MemoryStore store(1u << 20);
  NodeConfig config;
  config.self = kFriend;
  Node node(config, store);
  const auto refused = node.append(Instant{}, 0, 1, {1});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().text().find("no key"), std::string::npos);
  EXPECT_TRUE(node.frontier().empty());
}

// Offers a log's records and serves them, as a neighbour does.
struct Heard {
  Alone alone;
  std::uint32_t counter = 1;
  explicit Heard(const std::string& neighbour = "friend", NodeConfig config = {}) : alone(std::move(config)) {
    alone.befriend(neighbour, 5);
  }
  void offer(const LogId& log, std::uint32_t count) {
    const wire::HaveEntry entry{log, count};
    alone.hear_frames(5, ++counter, [&](auto& out) { out.have(1, {&entry, 1}); });
    alone.sent();
  }
  void serve(const Record& record) {
    alone.hear_record(5, ++counter, record);
    alone.sent();
  }
  // Without its body, for `by` took its place.
  void serve_head(const Record& record, const Record& by) {
    const SignedHead later{head_of(by), by.seal.signature};
    alone.hear_frames(5, ++counter, [&](auto& out) { out.head({head_of(record), 0, record.seal.signature, later}); });
    alone.sent();
  }
  void wait(Duration time) { alone.sent_within(time); }
  std::uint32_t held(const LogId& log) const {
    const auto at = alone.node.frontier().find(log);
    return at == alone.node.frontier().end() ? 0 : at->second;
  }
  std::uint64_t refused(Refusal reason) const { return alone.node.counters().of(reason); }
};

// A relay changes a record and makes the hash fit: the signature does not, the relay is named, and the record is taken
// when it is what its author wrote.
TEST(Signature, AForgedRecordIsRefusedAndWhoServedItIsNamed) {
  Heard heard("relay");
  SignedLogs logs;
  const Record first = logs.next(kPoses, 3, {7, 8}), second = logs.next(kPoses, 3, {9});
  heard.offer(kPoses, 2);
  heard.serve(first);
  EXPECT_EQ(heard.held(kPoses), 1u);
  Record forged = second;
  forged.body = {10};
  heard.serve(forged);
  EXPECT_EQ(heard.held(kPoses), 1u);
  EXPECT_EQ(heard.refused(Refusal::bad_signature), 1u);
  EXPECT_EQ(heard.refused(Refusal::data_bad_hash), 0u) << "its hash fits";
  const auto complaint = heard.alone.node.next_complaint();
  ASSERT_TRUE(complaint);
  EXPECT_EQ(complaint->reason, Refusal::bad_signature);
  EXPECT_EQ(complaint->record, second.id);
  EXPECT_EQ(complaint->from, RobotId::from_name("relay"));
  EXPECT_FALSE(heard.alone.node.next_complaint());
  heard.wait(2s);
  heard.serve(second);
  EXPECT_EQ(heard.held(kPoses), 2u);
}

TEST(Signature, ARobotHasOneKey) {
  Heard heard;
  SignedLogs logs;
  heard.offer(kPoses, 1);
  heard.serve(logs.next(kPoses, 3, {1}));
  EXPECT_EQ(heard.alone.node.key_of(kFriend), sim::identity_of(kFriend).public_key());
  // Another life, another lane, another key.
  const LogId later{kFriend, 2, 4};
  Record stolen{{later, 0}, 3, {1}, {}, {}};
  seal(stolen, {}, sim::identity_of(kStranger));
  heard.offer(later, 1);
  heard.serve(stolen);
  EXPECT_EQ(heard.held(later), 0u);
  EXPECT_EQ(heard.refused(Refusal::second_key), 1u);
  EXPECT_EQ(heard.alone.node.next_complaint()->reason, Refusal::second_key);
  heard.wait(2s);
  heard.serve(logs.next(later, 3, {1}));
  EXPECT_EQ(heard.held(later), 1u) << "with its own key it is welcome";
  EXPECT_FALSE(heard.alone.node.pin(kFriend, sim::identity_of(kStranger).public_key()));
  EXPECT_TRUE(heard.alone.node.pin(kFriend, sim::identity_of(kFriend).public_key()));
}

TEST(Signature, AnEarlierWordAboutAKeyCountsMoreThanTheFirstRecord) {
  Heard heard;
  EXPECT_TRUE(heard.alone.node.pin(kFriend, sim::identity_of(kStranger).public_key()));
  heard.offer(kPoses, 1);
  heard.serve(SignedLogs().next(kPoses, 3, {1}));
  EXPECT_EQ(heard.held(kPoses), 0u);
  EXPECT_EQ(heard.refused(Refusal::second_key), 1u);
}

// Nobody writes former lives of ours but we.
TEST(Signature, OurFormerLivesAreSignedByUs) {
  Heard heard;
  const LogId former{RobotId::from_name("self"), 1, 12};
  Record forged{{former, 0}, 3, {1}, {}, {}};
  seal(forged, {}, sim::identity_of(kFriend));
  heard.offer(former, 1);
  heard.serve(forged);
  EXPECT_EQ(heard.held(former), 0u);
  EXPECT_EQ(heard.refused(Refusal::second_key), 1u);
}

// The author signs two histories: after the first of them nothing of the other is taken, and nothing more of this log.
TEST(Signature, AnAuthorThatForksItsLogIsFoundOut) {
  Heard heard;
  SignedLogs one, two;
  const Record first = one.next(kPoses, 3, {1});
  two.next(kPoses, 3, {2});  // the other first record
  heard.offer(kPoses, 3);
  heard.serve(first);
  heard.serve(two.next(kPoses, 3, {3}));
  EXPECT_EQ(heard.held(kPoses), 1u);
  EXPECT_EQ(heard.refused(Refusal::forked), 1u);
  const auto complaint = heard.alone.node.next_complaint();
  ASSERT_TRUE(complaint);
  EXPECT_EQ(complaint->reason, Refusal::forked);
  EXPECT_EQ(complaint->record, (RecordId{kPoses, 1}));
  heard.offer(kPoses, 4);
  heard.serve(one.next(kPoses, 3, {4}));
  EXPECT_EQ(heard.held(kPoses), 1u);
  EXPECT_EQ(heard.alone.node.records_missing(), 0u) << "nobody waits for it";
  // Its other logs are what they are.
  const LogId other{kFriend, 2, 5};
  heard.offer(other, 1);
  heard.serve(one.next(other, 3, {1}));
  EXPECT_EQ(heard.held(other), 1u);
}

NodeConfig replaces(std::uint16_t kind) {
  NodeConfig config;
  config.keeping = [kind](std::uint16_t of) { return of == kind ? Keeping::until_the_next : Keeping::always; };
  return config;
}

TEST(Signature, AHeadIsAsGoodAsItsRecordForTheChain) {
  Heard heard("friend", replaces(3));
  SignedLogs logs;
  const Record first = logs.next(kPoses, 3, std::vector<std::uint8_t>(5000, 1)),
               second = logs.next(kPoses, 3, {2}, first.id.seq);
  heard.offer(kPoses, 2);
  Record forged = first;
  forged.seal.signature[5] ^= 1;
  heard.serve_head(forged, second);
  EXPECT_EQ(heard.refused(Refusal::bad_signature), 1u);
  heard.wait(2s);
  heard.serve_head(first, second);
  EXPECT_EQ(heard.held(kPoses), 1u);
  heard.serve(second);
  EXPECT_EQ(heard.held(kPoses), 2u);
  std::shared_ptr<const Record> record;
  ASSERT_TRUE(heard.alone.node.next_applied(record));
  ASSERT_TRUE(record->dropped);
  EXPECT_EQ(record->dropped->bytes, 5000u);
  EXPECT_EQ(record->kind, 3);
  EXPECT_TRUE(record->body.empty());
}

// A member of the team keeps the body of a record back that counts, and gives its head: with a later one that has not
// its author's signature, or of a kind of which each one counts, or that does not take its place. It is found out,
// named, and others are asked.
TEST(Signature, AHeadOfWhatCountsIsRefusedAndWhoServedItIsNamed) {
  enum class Lie { forged, every_one_counts, names_another };
  for (const Lie lie : {Lie::forged, Lie::every_one_counts, Lie::names_another}) {
    Heard heard("relay", lie == Lie::every_one_counts ? replaces(4) : replaces(3));
    SignedLogs logs;
    const Record first = logs.next(kPoses, 3, {7, 8});
    const Record true_one = logs.next(kPoses, 3, {9}, lie == Lie::names_another ? kNoSequence : first.id.seq);
    Record later = true_one;
    if (lie == Lie::forged) later.body = {1}, later.seal.signature[0] ^= 1;
    heard.offer(kPoses, 2);
    heard.serve_head(first, later);
    EXPECT_EQ(heard.held(kPoses), 0u) << "a map without it would be another one";
    EXPECT_EQ(heard.refused(Refusal::live_head), 1u);
    const auto complaint = heard.alone.node.next_complaint();
    ASSERT_TRUE(complaint);
    EXPECT_EQ(complaint->reason, Refusal::live_head);
    EXPECT_EQ(complaint->from, RobotId::from_name("relay"));
    EXPECT_EQ(complaint->record, first.id);
    // Somebody else has it whole.
    const Endpoint another = Endpoint::ipv4(127, 0, 0, 1, 7777);
    heard.alone.befriend("another", 6, another);
    const wire::HaveEntry entry{kPoses, 2};
    heard.alone.hear_frames(
        6, 2,
        [&](auto& out) {
          out.have(entry_digest(kPoses, 2), {&entry, 1});
        },
        another);
    const auto asked = sim::first<wire::Want>(heard.alone.sent_within(2s, another));
    ASSERT_TRUE(asked) << "it is asked of who has not lied";
    heard.alone.hear_record(6, 3, first, another);
    heard.alone.hear_record(6, 4, true_one, another);
    EXPECT_EQ(heard.held(kPoses), 2u);
    std::shared_ptr<const Record> record;
    ASSERT_TRUE(heard.alone.node.next_applied(record));
    EXPECT_EQ(record->body, first.body);
  }
}

// What everybody has forgotten costs a late joiner its head; what nobody has forgotten comes whole, over several hops.
TEST(Signature, DroppedBodiesTravelAsHeads) {
  sim::SimNet net(5, {.loss = 0.1});
  net.add_team(2, sim::line(2), replaces(1));
  for (int k = 0; k < 40; ++k) net.append(0, 3, 20'000);
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 60s));
  const LogId log{net[0].config.self, 3, 1};
  NodeConfig late = replaces(1);
  late.peers = {sim::SimNet::address(1)};
  const std::size_t joiner = net.add(late);
  net.connect(1, joiner);
  const std::uint64_t before = net.bytes_carried();
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 60s));
  EXPECT_LT(net.bytes_carried() - before, 100'000u) << "a body and 39 heads, not 800 kB";
  for (std::uint32_t seq = 0; seq < 40; ++seq) {
    const auto here = net[joiner].store->find({log, seq}), there = net[0].store->find({log, seq});
    EXPECT_EQ(here->dropped, there->dropped);
    EXPECT_EQ(here->body, there->body);
    EXPECT_EQ(here->dropped.has_value(), seq < 39);
  }
}

// Of other kinds a body goes once its author has named it and nobody here needs it any more, and not before.
TEST(Signature, ABodyIsLetGoOnlyWhenItsAuthorSaysSo) {
  sim::SimNet net(6, {.loss = 0.1});
  NodeConfig config;
  config.keeping = [](std::uint16_t) { return Keeping::until_it_may_go; };
  net.add_team(2, sim::line(2), config);
  const LogId log{net[0].config.self, 3, 1};
  const std::vector<std::uint8_t> body(20'000, 7);
  for (int k = 0; k < 6; ++k) net.append(0, 3, 20'000);
  ASSERT_TRUE(net.node(0).append(net.now(), 3, 1, body, 2).ok());
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 60s));
  for (std::uint32_t seq = 0; seq < 7; ++seq) EXPECT_EQ(net.node(1).let_go({log, seq}), seq == 2) << seq;
  EXPECT_FALSE(net.node(1).let_go({log, 2})) << "it is gone";
  // Who comes later gets a head of it and the bodies of the others, and the chain holds.
  NodeConfig late = config;
  late.peers = {sim::SimNet::address(1)};
  const std::size_t joiner = net.add(late);
  net.connect(1, joiner);
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 60s));
  for (std::uint32_t seq = 0; seq < 7; ++seq)
    EXPECT_EQ(net[joiner].store->find({log, seq})->dropped.has_value(), seq == 2) << seq;
  EXPECT_TRUE(net.node(0).store_full().empty());
}

}  // namespace
}  // namespace onemap::comms
