// share/wireshark/onemap.lua reads what the protocol writes, with the keys and without.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "session/group_seal.hpp"
#include "support/golden_talk.hpp"
#include "support/hex.hpp"
#include "support/temp_folder.hpp"

namespace onemap::comms {
namespace {

using testing::HasSubstr;
using testing::Not;

// A capture of UDP datagrams between 10.0.0.1 and 10.0.0.2, port 4600 (pcap, raw IPv4).
class Capture {
 public:
  Capture() {
    for (const std::uint32_t word : {0xA1B2C3D4u, 0x00040002u, 0u, 0u, 65535u, 101u}) little(word);
  }
  void add(std::span<const std::uint8_t> datagram) {
    const auto size = static_cast<std::uint32_t>(28 + datagram.size());
    for (const std::uint32_t word : {0u, 0u, size, size}) little(word);
    for (const std::uint32_t half :
         {0x4500u, size, 0u, 0u, 0x4011u, 0u, 0x0A00u, 1u, 0x0A00u, 2u, 4600u, 4600u, size - 20, 0u}) {
      bytes_.push_back(static_cast<std::uint8_t>(half >> 8));
      bytes_.push_back(static_cast<std::uint8_t>(half));
    }
    bytes_.insert(bytes_.end(), datagram.begin(), datagram.end());
  }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  void little(std::uint32_t word) {
    for (int i = 0; i < 4; ++i) bytes_.push_back(static_cast<std::uint8_t>(word >> (8 * i)));
  }
  std::vector<std::uint8_t> bytes_;
};

std::string output_of(const std::string& command) {
  std::FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
  std::string text;
  std::array<char, 4096> part{};
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), n);
  pclose(pipe);
  return text;
}

std::string index_text(std::uint32_t index) {
  std::array<std::uint8_t, 4> bytes{};
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(index >> (8 * i));
  return test::to_hex(bytes);
}

TEST(Wireshark, OpensOurTrafficWithTheKeysAlone) {
  if (output_of("tshark --version").find("with Lua") == std::string::npos) GTEST_SKIP() << "no tshark with Lua here";
  golden::Talk talk;
  Capture capture;
  capture.add(talk.hello);
  capture.add(talk.answer);
  capture.add(talk.proof);
  const auto plain = golden::beacon();
  std::vector<std::uint8_t> frames(plain.size() + sealed::kOverheadBytes);
  std::copy(plain.begin(), plain.end(), frames.begin() + sealed::kHeaderBytes);
  Transport& session = *talk.initiation.made();
  session.seal(frames, plain.size(), 77);
  capture.add(frames);
  std::vector<std::uint8_t> word(sealed::kOwnBytes);
  session.say(word, sealed::Word::probe, 4711);
  capture.add(word);
  frames[20] ^= 1;
  capture.add(frames);
  GroupSeal group(talk.team.group, 7);
  OutgoingDatagram beacon;
  wire::write_header(beacon.buffer, {wire::DatagramType::group, 7, 0, 1});
  std::copy(plain.begin(), plain.end(), beacon.buffer.begin() + wire::kHeaderBytes);
  beacon.size = wire::kHeaderBytes + plain.size();
  capture.add(beacon.bytes());  // of a team without a key
  group.seal(beacon, golden::counting_from(0x30));
  capture.add(beacon.bytes());

  const test::TempFolder folder;
  folder.write("capture.pcap", capture.bytes());
  folder.write("keys", "SESSION " + index_text(session.their_index()) + " " +
                           test::to_hex(session.sending_key().bytes) + "\nGROUP " +
                           test::to_hex(talk.team.group.bytes) + "\n");
  const std::string look = "tshark -X lua_script:" ONEMAP_SOURCE_DIR "/share/wireshark/onemap.lua -r " +
                           folder / "capture.pcap" +
                           " -T fields -e frame.number -e _ws.col.Info -e onemap.robot "
                           "-e onemap.map -e onemap.token -e _ws.expert.message -E separator=/s";
  const std::string open = output_of(look + " -o onemap.keys:" + folder / "keys");
  EXPECT_THAT(open, HasSubstr("\n2 ANSWER")) << open;
  EXPECT_THAT(open, HasSubstr("\n3 PROOF"));
  EXPECT_THAT(open, HasSubstr("\n4 FRAMES: BEACON anna 0x99aabbccddeeff00"));
  EXPECT_THAT(open, HasSubstr("\n5 OWN: probe   4711"));
  EXPECT_THAT(open, HasSubstr("\n6 FRAMES    the tag is wrong"));
  EXPECT_THAT(open, HasSubstr("\n7 plain: BEACON anna"));
  EXPECT_THAT(open, HasSubstr("\n8 GROUP: BEACON anna 0x99aabbccddeeff00"));
  EXPECT_THAT(open, Not(HasSubstr("Lua Error")));
  const std::string closed = output_of(look);
  EXPECT_THAT(closed, HasSubstr("\n4 FRAMES    no key of it in the key log")) << closed;
  EXPECT_THAT(closed, HasSubstr("\n8 GROUP    no key of it in the key log"));
}

}  // namespace
}  // namespace onemap::comms
