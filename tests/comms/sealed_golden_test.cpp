// Sealed datagrams with fixed keys and nonces, byte for byte: what another implementation has to write and to read.
#include <gtest/gtest.h>

#include "comms/fingerprint.hpp"
#include "comms/wire.hpp"
#include "session/cookies.hpp"
#include "session/group_seal.hpp"
#include "support/golden_talk.hpp"
#include "support/hex.hpp"

namespace onemap::comms {
namespace {

using test::to_hex;

using golden::beacon;
using golden::counting_from;
using golden::kNow;
using golden::kTeam;
using golden::Talk;

TEST(SealedGolden, KeysDerivedFromTheTeams) {
  const TeamSecrets team(kTeam);
  EXPECT_EQ(to_hex(team.psk.bytes), "95fe6827280bbfe3e47935e78a7e4233610354a4d7800ebd396210b62dffcc80");
  EXPECT_EQ(to_hex(team.mac.bytes), "2353fd28d7089688aa239a4ad5e8b6994b2ec99fabaedf1e0d003d23e9fd4f01");
  EXPECT_EQ(to_hex(team.cookie.bytes), "0e66faf02307be00b8232cf7741bfa3e9d767c6e7607d1173d380689eb8872a1");
  EXPECT_EQ(to_hex(team.group.bytes), "a5038de7400476c2756a5dec8cc3afae5b6de6f47295dc9353eb45017b9d7336");
  EXPECT_EQ(fingerprint(kTeam), "f082-68be-a4f0-0d85");
}

TEST(SealedGolden, Hello) {
  const Talk talk;
  ASSERT_EQ(talk.hello.size(), 1200u);
  EXPECT_EQ(to_hex(Bytes(talk.hello).first(88)),
            "b2010000a4a3a2a1392d174a38b3b1beafaf1fe824870841c5fa531bc6eafdb6402c124664488c1c93358740"
            "551aebc0db034dd048e88885f0d5a93b8f4a9e359544592a21f2a8cc00000000000000000000000000000000");
  for (std::size_t i = 88; i < talk.hello.size(); ++i) ASSERT_EQ(talk.hello[i], 0u) << i;
}

TEST(SealedGolden, AnswerAndProof) {
  const Talk talk;
  EXPECT_EQ(to_hex(talk.answer),
            "b2020000b4b3b2b1a4a3a2a1dc2cca31e8e43bbd91dff7e475cca3347eb478107d5bd765aba4ae4a30c35d44"
            "195b94786a9fea7d8ac425986f9bc2dba1745208fbb37aa87a6ebae06c84f42e7e5b5743abd52373010b6065"
            "8e45647ad795a92ecc7b0f3a6e540786c272087c60bd6a5bd015333655b91b007f512d095acc22bc1b2142b9"
            "49e40e02d6b99fa80fe8375b2ec3902153c8129da0f1fbe2e1dd33e3557fff89d48ed60b428317ff180e2ad8"
            "43454531feef7c152ccd71a71113acacee1a617c986ff1cfb36fd9831496d5334f8df81ae68671d49b4c1415"
            "29cba5f1834851891f57794cd8cd2e45547892eec835671f");
  EXPECT_EQ(to_hex(talk.proof),
            "b2030000a4a3a2a1b4b3b2b134601ece4d0942bcdf198b23ce2a2b2f241300a76baa385272a33e1bba1d8e05"
            "7afade940da73d6cec93739e889650ea511061074e6a10853aa2350fbceedbac786f1ef94b5942fea11c1cda"
            "0c17f44158c95e224a2d5a5aef15922d27e9aa5c0229dde2ee99fef235531d1d36a828c17c67ba7820bb67db"
            "33f0f84c688a6491b7000a962b85bbfb551e113d17443fa49e45edc79c8150d86d0ce80826b30e05f6462446"
            "dc7efb03b2ab0c1fddecda155bbfedf477b682a2a833b725585ca63cab1f32d3a762fd3d");
  EXPECT_EQ(talk.of_anna.robot.name(), "anna");
  EXPECT_EQ(talk.of_bert.robot.name(), "bert");
  EXPECT_EQ(talk.of_bert.incarnation, 7u);
}

TEST(SealedGolden, FramesAndOwnWords) {
  Talk talk;
  Transport& anna = *talk.initiation.made();
  Transport bert = talk.half.made(kNow, talk.of_anna);
  EXPECT_EQ(to_hex(anna.sending_key().bytes), "625540619b412c2dff90ba5539a5b417f3606912b22350a618c8ef2bf9c40d2b");
  EXPECT_EQ(to_hex(anna.receiving_key().bytes), "eebbc5da2f16a5d6fe331624c403383a8583d170d28f42855f94cb371f4c03b6");
  const auto plain = beacon();
  std::vector<std::uint8_t> datagram(plain.size() + sealed::kOverheadBytes), opened(plain.size());
  std::copy(plain.begin(), plain.end(), datagram.begin() + sealed::kHeaderBytes);
  ASSERT_EQ(anna.seal(datagram, plain.size(), 0x01020304), datagram.size());
  EXPECT_EQ(to_hex(datagram),
            "b2050000b4b3b2b10403020100000000f75de45042cfc3fabcf12ac197de025c2bfb736c69143c564deeb58c"
            "badcb024a7b7ce363480a0167c9ad1a0531d6c2cfc5b3d16d56d1fa6");
  ASSERT_EQ(bert.open(datagram, opened), Refusal::count);
  EXPECT_EQ(opened, plain);
  std::vector<std::uint8_t> word(sealed::kOwnBytes);
  bert.say(word, sealed::Word::probe, 0x0807060504030201);
  EXPECT_EQ(to_hex(word), "b2060000a4a3a2a10100000000000000e6fe15fb4bc8d1673cf6217bf073b71120f015359ef2de4ddd");
  Transport::Said said{};
  ASSERT_EQ(anna.hear(word, said), Refusal::count);
  EXPECT_EQ(said.word, sealed::Word::probe);
  EXPECT_EQ(said.token, 0x0807060504030201u);
}

TEST(SealedGolden, Cookie) {
  Talk talk;
  CookieJar jar;
  const auto cookie =
      jar.reply(kNow, Endpoint::ipv4(10, 0, 0, 1, 4600), talk.hello, talk.team.cookie, counting_from(0));
  EXPECT_EQ(to_hex(cookie),
            "b2040000a4a3a2a1000102030405060708090a0b0c0d0e0f10111213141516177d98e2f517a7ee53cbf27090"
            "0049f1ca645e03f27f7582ea0372198922fb890d");
  Mac mac1;
  std::copy_n(talk.hello.begin() + sealed::kHelloMac1At, mac1.size(), mac1.begin());
  const auto opened = open_cookie(cookie, talk.team.cookie, mac1);
  ASSERT_TRUE(opened.has_value());
  pay(talk.hello, *opened);
  EXPECT_EQ(to_hex(Bytes(talk.hello).subspan(sealed::kHelloMac2At, 16)), "29ba0e81f823eb2e5d57c6fbfd595fec");
  EXPECT_TRUE(jar.pays(kNow, Endpoint::ipv4(10, 0, 0, 1, 4600), talk.hello));
  EXPECT_FALSE(jar.pays(kNow, Endpoint::ipv4(10, 0, 0, 1, 4601), talk.hello));
  EXPECT_FALSE(jar.pays(kNow + std::chrono::seconds(121), Endpoint::ipv4(10, 0, 0, 1, 4600), talk.hello));
}

TEST(SealedGolden, Group) {
  const TeamSecrets team(kTeam);
  GroupSeal sender(team.group, 7), receiver(team.group, 9);
  OutgoingDatagram datagram;
  const auto plain = beacon();
  wire::write_header(datagram.buffer, {wire::DatagramType::group, 7, 0, 1});
  std::copy(plain.begin(), plain.end(), datagram.buffer.begin() + wire::kHeaderBytes);
  datagram.size = wire::kHeaderBytes + plain.size();
  sender.seal(datagram, counting_from(0x30));
  EXPECT_EQ(to_hex(datagram.bytes()),
            "b2090000303132333435363738393a3b3c3d3e3f404142434445464795690f66f00e6bc66bf0e9d81308e6b9"
            "ff9bb0e0d26cb5e6ee26aa8ae6e41ddf6504f63be78a8d6fdbe54197f9e3928e914ce2d2ae83ad685282c828"
            "e67a368ff2326fc622d39c5c");
  std::array<std::uint8_t, kMaxDatagramBytes> room;
  GroupSeal::Opened opened;
  ASSERT_EQ(receiver.open(kNow, datagram.bytes(), room, opened), Refusal::count);
  EXPECT_EQ(opened.robot.name(), "anna");
  EXPECT_EQ(opened.incarnation, 7u);
  EXPECT_EQ(opened.counter, 1u);
  EXPECT_EQ(std::vector<std::uint8_t>(opened.frames.begin(), opened.frames.end()), plain);
  EXPECT_EQ(receiver.open(kNow, datagram.bytes(), room, opened), Refusal::duplicate) << "a copy says nothing";
  for (std::size_t bit = 0; bit < 8 * datagram.size; bit += 3) {
    GroupSeal fresh(team.group, 9);
    OutgoingDatagram bad = datagram;
    bad.buffer[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    ASSERT_EQ(fresh.open(kNow, bad.bytes(), room, opened), Refusal::bad_seal) << bit;
  }
}

// Those of a former life, or overtaken, are no news, whoever sends them on.
TEST(SealedGolden, OfASenderInAGroupOnlyWhatIsNewer) {
  const TeamSecrets team(kTeam);
  std::array<std::uint8_t, kMaxDatagramBytes> room;
  GroupSeal::Opened opened;
  const auto sealed_by = [&](GroupSeal& sender) {
    OutgoingDatagram datagram;
    const auto plain = beacon();
    wire::write_header(datagram.buffer, {wire::DatagramType::group, 7, 0, 1});
    std::copy(plain.begin(), plain.end(), datagram.buffer.begin() + wire::kHeaderBytes);
    datagram.size = wire::kHeaderBytes + plain.size();
    sender.seal(datagram, counting_from(1));
    return datagram;
  };
  GroupSeal before(team.group, 7), after(team.group, 8), receiver(team.group, 9);
  const auto one = sealed_by(before), two = sealed_by(before), three = sealed_by(before), later = sealed_by(after);
  EXPECT_EQ(receiver.open(kNow, two.bytes(), room, opened), Refusal::count);
  EXPECT_EQ(receiver.open(kNow, one.bytes(), room, opened), Refusal::duplicate);
  EXPECT_EQ(receiver.open(kNow, later.bytes(), room, opened), Refusal::count);
  EXPECT_EQ(receiver.open(kNow, three.bytes(), room, opened), Refusal::duplicate);
}

}  // namespace
}  // namespace onemap::comms
