#include "comms/wire.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "sim_net.hpp"

namespace onemap::comms::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes hex(const std::string& text) {
  Bytes out;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == ' ') {
      ++i;
      continue;
    }
    out.push_back(static_cast<std::uint8_t>(std::stoul(text.substr(i, 2), nullptr, 16)));
    i += 2;
  }
  return out;
}

std::string repeated(const std::string& byte, int times) {
  std::string out;
  for (int k = 0; k < times; ++k) out += byte;
  return out;
}

const Header kHeader{DatagramType::unicast, 0x1122334455667788u, 0x0102030405060708u, 9};
const std::string kHeaderHex = "b1 08 0000 8877665544332211 0807060504030201 09000000 ";
const std::string kRobotHex = "726f626f743100000000000000000000 ";  // "robot1"
const LogId kLog{RobotId::from_name("robot1"), 3, 0xA0B0C0D0E0F00102u};
const std::string kLogHex = kRobotHex + "03 0201f0e0d0c0b0a0 ";

template <class Write>
Bytes written(Write write) {
  std::array<std::uint8_t, kMaxDatagramBytes> buffer{};
  Encoder out(buffer, kHeader);
  write(out);
  return Bytes(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(out.size()));
}

// Checks both directions against bytes written down by hand from PROTOCOL.md, and gives the decoded frame.
Frame golden(const Bytes& encoded, const std::string& frame_hex, Decoder& decoder) {
  EXPECT_EQ(encoded, hex(kHeaderHex + frame_hex));
  EXPECT_EQ(decoder.decode(encoded), Refusal::count);
  EXPECT_EQ(decoder.header(), kHeader);
  EXPECT_EQ(decoder.frames().size(), 1u);
  return decoder.frames().front();
}

TEST(Wire, GoldenBeacon) {
  const Beacon beacon{RobotId::from_name("robot1"), 0x1111111111111122u, 0x3333333333333344u, 0x55667788u, 1};
  Decoder decoder;
  const Frame frame = golden(written([&](Encoder& out) { ASSERT_TRUE(out.beacon(beacon)); }),
                             "01 2500 " + kRobotHex + "2211111111111111 4433333333333333 88776655 01", decoder);
  EXPECT_EQ(std::get<Beacon>(frame), beacon);
}

TEST(Wire, GoldenStatus) {
  const RobotStatus status{RobotId::from_name("robot1"), 7, 0x01020304u, 0xAAu, 0xBBu, 1};
  Decoder decoder;
  const Frame frame =
      golden(written([&](Encoder& out) {
               ASSERT_EQ(out.status({&status, 1}), 1u);
             }),
             "02 2d00 " + kRobotHex + "0700000000000000 04030201 aa00000000000000 bb00000000000000 01", decoder);
  ASSERT_EQ(std::get<Status>(frame).robots.size(), 1u);
  EXPECT_EQ(std::get<Status>(frame).robots[0], status);
}

TEST(Wire, GoldenHave) {
  const std::array<HaveEntry, 2> entries{{{kLog, 0x10}, {kLog, 0x11}}};
  Decoder decoder;
  const Frame frame = golden(written([&](Encoder& out) { ASSERT_EQ(out.have(0x77, entries), 2u); }),
                             "03 4200 7700000000000000 " + kLogHex + "10000000 " + kLogHex + "11000000", decoder);
  EXPECT_EQ(std::get<Have>(frame).frontier_digest, 0x77u);
  ASSERT_EQ(std::get<Have>(frame).entries.size(), 2u);
  EXPECT_EQ(std::get<Have>(frame).entries[1], entries[1]);
}

TEST(Wire, GoldenHaveRequestPingPong) {
  Decoder decoder;
  golden(written([](Encoder& out) { ASSERT_TRUE(out.have_request()); }), "04 0000", decoder);
  EXPECT_EQ(std::get<Ping>(
                golden(written([](Encoder& out) { ASSERT_TRUE(out.ping(0xDDCCBBAA)); }), "07 0400 aabbccdd", decoder))
                .token,
            0xDDCCBBAAu);
  EXPECT_EQ(std::get<Pong>(golden(written([](Encoder& out) { ASSERT_TRUE(out.pong(1)); }), "08 0400 01000000", decoder))
                .token,
            1u);
}

TEST(Wire, GoldenWant) {
  const WantEntry entry{{kLog, 5}, 2, 0x0103};
  Decoder decoder;
  const Frame frame = golden(written([&](Encoder& out) {
                               ASSERT_EQ(out.want(0x40000, {&entry, 1}), 1u);
                             }),
                             "05 2500 00000400 " + kLogHex + "05000000 0200 0301", decoder);
  EXPECT_EQ(std::get<Want>(frame).credit_bytes, 0x40000u);
  ASSERT_EQ(std::get<Want>(frame).entries.size(), 1u);
  EXPECT_EQ(std::get<Want>(frame).entries[0], entry);
}

TEST(Wire, GoldenData) {
  Bytes body = {0xDE, 0xAD};  // and its seal
  body.resize(2 + kSealBytes, 0x11);
  Data data;
  data.id = {kLog, 5};
  data.kind = 0x0204;
  data.hops = 3;
  data.total_bytes = 102;
  data.body_hash = 0x0807060504030201u;
  data.bytes = body;
  Decoder decoder;
  const Bytes encoded = written([&](Encoder& out) { ASSERT_TRUE(out.data(data)); });
  const Frame frame = golden(
      encoded, "06 9400 " + kLogHex + "05000000 0402 03 66000000 0102030405060708 0000 dead" + repeated("11", 100),
      decoder);
  const Data& back = std::get<Data>(frame);
  EXPECT_EQ(back.id, data.id);
  EXPECT_EQ(back.kind, data.kind);
  EXPECT_EQ(back.hops, 3);
  EXPECT_EQ(back.total_bytes, 102u);
  EXPECT_EQ(back.body_hash, data.body_hash);
  EXPECT_EQ(Bytes(back.bytes.begin(), back.bytes.end()), body);
}

TEST(Wire, GoldenMass) {
  Mass mass;
  mass.heard = 0x0201, mass.neighbours = 3, mass.round = 0x0807060504030201u, mass.clock_ns = -2;
  const Bytes head{129, 19, 0, 1, 2, 3, 1, 2, 3, 4, 5, 6, 7, 8, 0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
  const Bytes bare = written([&](Encoder& out) { ASSERT_TRUE(out.mass(mass)); });
  EXPECT_EQ(Bytes(bare.begin() + kHeaderBytes, bare.end()), head);
  mass.has_amounts = true;
  mass.given = {comms::Mass{1.0, -2.0}, comms::Mass{0.5, 0.0}, comms::Mass{0.0, 1.0}};
  const Bytes whole = written([&](Encoder& out) { ASSERT_TRUE(out.mass(mass)); });
  ASSERT_EQ(whole.size(), kHeaderBytes + kFrameHeadBytes + 67);
  EXPECT_EQ(whole[kHeaderBytes + 1], 67);
  const Bytes amounts{0, 0, 0, 0, 0, 0, 0xF0, 0x3F, 0, 0, 0, 0, 0, 0, 0, 0xC0, 0, 0, 0, 0, 0, 0, 0xE0, 0x3F};
  EXPECT_TRUE(std::equal(amounts.begin(), amounts.end(), whole.begin() + kHeaderBytes + 22));
  Decoder decoder;
  ASSERT_EQ(decoder.decode(whole), Refusal::count);
  const auto& read = std::get<Mass>(decoder.frames()[0]);
  EXPECT_EQ(read.given, mass.given);
  EXPECT_EQ(read.clock_ns, -2);
  EXPECT_EQ(type_of(decoder.frames()[0]), FrameType::mass);
  Bytes cut(whole.begin(), whole.end() - 1);
  cut[kHeaderBytes + 1] = 66;
  EXPECT_EQ(decoder.decode(cut), Refusal::bad_frame) << "amounts are whole";
  mass.round = 0;
  EXPECT_EQ(decoder.decode(written([&](Encoder& out) { out.mass(mass); })), Refusal::bad_frame)
      << "amounts of no round";
}

TEST(Wire, GoldenHead) {
  Head head;
  head.record = {{kLog, 5}, 0x0204, 0x00012345, {}, {}, 0x01020304};
  head.record.body.fill(0xB0);
  head.record.previous.fill(0xC0);
  head.signature.fill(0xD0);
  head.hops = 3;
  head.by.head = {{kLog, 9}, 0x0204, 0x00000102, {}, {}, 5};
  head.by.head.body.fill(0xE0);
  head.by.head.previous.fill(0xE1);
  head.by.signature.fill(0xE2);
  Decoder decoder;
  const Frame frame = golden(written([&](Encoder& out) { ASSERT_TRUE(out.head(head)); }),
                             "0b 3001 " + kLogHex + "05000000 0402 03 45230100 " + repeated("b0", 32) +
                                 repeated("c0", 32) + "04030201" + repeated("d0", 64) + "09000000 02010000" +
                                 repeated("e0", 32) + repeated("e1", 32) + repeated("e2", 64),
                             decoder);
  EXPECT_EQ(type_of(frame), FrameType::head);
  const Head& back = std::get<Head>(frame);
  EXPECT_EQ(signed_bytes(back.record), signed_bytes(head.record));
  EXPECT_EQ(back.hops, 3);
  EXPECT_EQ(back.signature, head.signature);
  EXPECT_EQ(signed_bytes(back.by.head), signed_bytes(head.by.head)) << "of the same log and kind";
  EXPECT_EQ(back.by.signature, head.by.signature);
  const auto refused = [&](const Head& wrong) {
    return decoder.decode(written([&](Encoder& out) { out.head(wrong); })) == Refusal::bad_frame;
  };
  Head wrong = head;
  wrong.record.bytes = kMaxRecordBytes + 1;
  EXPECT_TRUE(refused(wrong));
  wrong = head;
  wrong.by.head.bytes = kMaxRecordBytes + 1;
  EXPECT_TRUE(refused(wrong));
  wrong = head;
  wrong.by.head.id.seq = head.record.id.seq;
  EXPECT_TRUE(refused(wrong)) << "nothing takes its own place";
}

TEST(Wire, GoldenFeedback) {
  const Feedback feedback{0x01020304u, 0x11121314u, 0x21222324u, 0x31323334u};
  Decoder decoder;
  const Frame frame = golden(written([&](Encoder& out) { ASSERT_TRUE(out.feedback(feedback)); }),
                             "0a 1000 04030201 14131211 24232221 34333231", decoder);
  EXPECT_EQ(std::get<Feedback>(frame), feedback);
  EXPECT_EQ(type_of(frame), FrameType::feedback);
}

TEST(Wire, GoldenLaterLife) {
  const LaterLife later{RobotId::from_name("robot1"), 0x0102030405060708u};
  Decoder decoder;
  const Bytes encoded = written([&](Encoder& out) { ASSERT_TRUE(out.later_life(later)); });
  const Frame frame = golden(encoded, "80 1800 " + kRobotHex + "0807060504030201", decoder);
  EXPECT_EQ(std::get<LaterLife>(frame), later);
  EXPECT_EQ(type_of(frame), FrameType::later_life);
  const Bytes greeting = written([&](Encoder& out) { ASSERT_TRUE(out.beacon({later.robot, 0, 0, 1, 0})); });
  EXPECT_LT(encoded.size(), greeting.size()) << "whoever is told gets no more than it sent";
}

// One in each place where a datagram names a robot.
TEST(Wire, RobotsWithoutAValidNameVoidTheDatagram) {
  const Bytes body(kSealBytes, 1);
  for (const std::string& name : {std::string("../x"), std::string("a/b"), std::string(".."), std::string("\x1b[31m"),
                                  std::string("a\0b", 3), std::string("\0b", 2), std::string("r\xff"), std::string()}) {
    RobotId id;
    std::copy(name.begin(), name.end(), id.bytes.begin());
    const LogId log{id, 1, 1};
    const HaveEntry have{log, 1};
    const WantEntry want{{log, 0}, 0, 1};
    const RobotStatus status{id, 1, 1, 0, 0, 0};
    Data data;
    data.id = {log, 0};
    data.total_bytes = kSealBytes;
    data.bytes = body;
    Decoder decoder;
    const auto decoded = [&](auto write) { return decoder.decode(written(write)); };
    EXPECT_EQ(decoded([&](Encoder& out) { out.beacon({id, 0, 0, 1, 0}); }), Refusal::bad_robot_id) << name;
    EXPECT_EQ(decoded([&](Encoder& out) { out.status({&status, 1}); }), Refusal::bad_robot_id) << name;
    EXPECT_EQ(decoded([&](Encoder& out) { out.have(1, {&have, 1}); }), Refusal::bad_robot_id) << name;
    EXPECT_EQ(decoded([&](Encoder& out) { out.want(1, {&want, 1}); }), Refusal::bad_robot_id) << name;
    EXPECT_EQ(decoded([&](Encoder& out) { out.data(data); }), Refusal::bad_robot_id) << name;
    EXPECT_EQ(decoded([&](Encoder& out) { out.later_life({id, 1}); }), Refusal::bad_robot_id) << name;
  }
}

TEST(Wire, CountersGoRoundWithoutZero) {
  EXPECT_EQ(next_counter(1), 2u);
  EXPECT_EQ(next_counter(0xFFFFFFFE), 0xFFFFFFFFu);
  EXPECT_EQ(next_counter(0xFFFFFFFF), 1u);
}

TEST(Wire, BodyHashIsXxh3) {
  EXPECT_EQ(body_hash(0, {}), 0x2D06800538D394C2u);  // the published XXH3-64 of nothing with seed 0
  EXPECT_NE(body_hash(1, {}), body_hash(0, {}));
}

TEST(Wire, FragmentsCoverTheBody) {
  EXPECT_EQ(fragments_of(0), 1u);
  EXPECT_EQ(fragments_of(1), 1u);
  EXPECT_EQ(fragments_of(kFragmentBytes), 1u);
  EXPECT_EQ(fragments_of(kFragmentBytes + 1), 2u);
  EXPECT_EQ(fragments_of(kMaxRecordBytes), 943u);
  // A whole fragment fits one datagram.
  const Bytes body(kFragmentBytes, 1);
  Data data;
  data.id = {kLog, 0};
  data.total_bytes = kFragmentBytes;
  data.bytes = body;
  EXPECT_LE(written([&](Encoder& out) { ASSERT_TRUE(out.data(data)); }).size(), kHeaderBytes + kMaxFramesBytes);
}

TEST(Wire, ListsAreCutToWhatFits) {
  const std::vector<HaveEntry> have(100, {kLog, 1});
  const std::vector<WantEntry> want(100, {{kLog, 1}, 0, 1});
  const std::vector<RobotStatus> status(100, {kLog.robot, 1, 1, 1, 1, 0});
  Decoder decoder;
  EXPECT_EQ(decoder.decode(written([&](Encoder& out) { EXPECT_EQ(out.have(1, have), 39u); })), Refusal::count);
  EXPECT_EQ(decoder.decode(written([&](Encoder& out) { EXPECT_EQ(out.want(1, want), 35u); })), Refusal::count);
  EXPECT_EQ(decoder.decode(written([&](Encoder& out) { EXPECT_EQ(out.status(status), 25u); })), Refusal::count);
}

TEST(Wire, RefusesEachKindOfNonsense) {
  Decoder decoder;
  const Bytes good = written([](Encoder& out) { ASSERT_TRUE(out.ping(1)); });
  const auto with = [&](std::size_t at, std::uint8_t value) {
    Bytes bytes = good;
    bytes[at] = value;
    return decoder.decode(bytes);
  };
  EXPECT_EQ(decoder.decode(good), Refusal::count);
  EXPECT_EQ(decoder.decode({}), Refusal::too_short);
  EXPECT_EQ(decoder.decode(Bytes(good.begin(), good.begin() + 23)), Refusal::too_short);
  EXPECT_EQ(decoder.decode(Bytes(1193, 0xB1)), Refusal::too_long);
  EXPECT_EQ(with(0, 0xA1), Refusal::bad_magic);
  EXPECT_EQ(with(0, 0xB2), Refusal::bad_version);
  EXPECT_EQ(with(1, 6), Refusal::bad_type);
  EXPECT_EQ(with(3, 1), Refusal::bad_reserved);
  EXPECT_EQ(with(24, 0), Refusal::bad_frame);  // unknown, not skippable
  EXPECT_EQ(with(24, 127), Refusal::bad_frame);
  EXPECT_EQ(with(24, 130), Refusal::count);  // unknown, skippable
  EXPECT_EQ(with(24, 255), Refusal::count);
  EXPECT_EQ(with(11, 0x80), Refusal::bad_incarnation);  // of the sender
  EXPECT_EQ(with(25, 5), Refusal::bad_frame);           // longer than the datagram
  EXPECT_EQ(with(25, 3), Refusal::bad_frame);           // shorter than a ping
  EXPECT_EQ(with(20, 0), Refusal::bad_frame);           // counter 0
  Bytes trailing = good;
  trailing.push_back(1);
  EXPECT_EQ(decoder.decode(trailing), Refusal::bad_frame);
}

TEST(Wire, RefusesImpossibleFragments) {
  const Bytes body(100, 1);
  Data data;
  data.id = {kLog, 0};
  data.total_bytes = 100;
  data.bytes = body;
  Decoder decoder;
  const auto decoded = [&](const Data& d) {
    return decoder.decode(written([&](Encoder& out) { ASSERT_TRUE(out.data(d)); }));
  };
  EXPECT_EQ(decoded(data), Refusal::count);
  Data wrong = data;
  wrong.fragment = 1;  // behind the end
  EXPECT_EQ(decoded(wrong), Refusal::bad_frame);
  wrong = data;
  wrong.total_bytes = 101;  // the fragment is too short
  EXPECT_EQ(decoded(wrong), Refusal::bad_frame);
  wrong = data;
  wrong.total_bytes = kMaxPayloadBytes + 1;
  EXPECT_EQ(decoded(wrong), Refusal::bad_frame);
  wrong = data;
  wrong.total_bytes = kSealBytes - 1;  // no room for its seal
  wrong.bytes = std::span(body).first(kSealBytes - 1);
  EXPECT_EQ(decoded(wrong), Refusal::bad_frame);
  wrong = data;
  wrong.id.log.lane = kLaneCount;
  EXPECT_EQ(decoded(wrong), Refusal::bad_frame);
  wrong = data;
  wrong.id.log.incarnation = 0;
  EXPECT_EQ(decoded(wrong), Refusal::bad_frame);
}

TEST(Wire, RandomBytesAreRefused) {
  sim::Random random(11);
  Decoder decoder;
  for (int round = 0; round < 100'000; ++round) {
    Bytes bytes(random.below(1300));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next());
    const bool plausible = random.below(2) == 0 && bytes.size() >= 24;
    if (plausible) {
      const Bytes header = hex(kHeaderHex);
      std::copy(header.begin(), header.end(), bytes.begin());
    }
    decoder.decode(bytes);  // must not crash or read out of bounds (sanitizers watch)
  }
}

}  // namespace
}  // namespace onemap::comms::wire
