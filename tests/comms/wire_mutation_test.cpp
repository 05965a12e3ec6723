#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <variant>
#include <vector>

#include "comms/wire.hpp"
#include "sim_net.hpp"

namespace onemap::comms::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes encode_again(const Decoder& decoder) {
  std::array<std::uint8_t, kMaxDatagramBytes> buffer{};
  Encoder out(buffer, decoder.header());
  for (const Frame& frame : decoder.frames()) {
    if (const auto* beacon = std::get_if<Beacon>(&frame)) out.beacon(*beacon);
    if (const auto* status = std::get_if<Status>(&frame)) out.status(status->robots);
    if (const auto* have = std::get_if<Have>(&frame)) out.have(have->frontier_digest, have->entries);
    if (std::holds_alternative<HaveRequest>(frame)) out.have_request();
    if (const auto* want = std::get_if<Want>(&frame)) out.want(want->credit_bytes, want->entries);
    if (const auto* data = std::get_if<Data>(&frame)) out.data(*data);
    if (const auto* head = std::get_if<Head>(&frame)) out.head(*head);
    if (const auto* ping = std::get_if<Ping>(&frame)) out.ping(ping->token);
    if (const auto* pong = std::get_if<Pong>(&frame)) out.pong(pong->token);
    if (const auto* feedback = std::get_if<Feedback>(&frame)) out.feedback(*feedback);
    if (const auto* later = std::get_if<LaterLife>(&frame)) out.later_life(*later);
    if (const auto* mass = std::get_if<Mass>(&frame)) out.mass(*mass);
  }
  return Bytes(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(out.size()));
}

// Mutations of real traffic: whatever is accepted has one encoding only (skippable frames and empty lists aside).
TEST(WireMutation, MutatedTrafficIsRefusedOrMeansWhatItSays) {
  std::vector<Bytes> corpus;
  sim::SimNet net(3, {.loss = 0.2});
  net.add_team(3, sim::line(3));
  net.tap = [&](std::size_t, const Endpoint&, std::span<const std::uint8_t> bytes) {
    if (corpus.size() < 400) corpus.emplace_back(bytes.begin(), bytes.end());
  };
  for (std::size_t i = 0; i < 3; ++i) net.append(i, 3, 30'000);
  net.run_for(std::chrono::seconds(3));
  ASSERT_GT(corpus.size(), 100u);
  sim::Random random(7);
  Decoder decoder;
  std::size_t accepted = 0, refused = 0;
  for (int round = 0; round < 200'000; ++round) {
    Bytes bytes = corpus[random.below(corpus.size())];
    for (std::uint64_t k = random.below(4); k > 0 && !bytes.empty(); --k) {
      // The headers of datagram and frame are hit more often than their share.
      const std::size_t at =
          random.below(random.below(2) == 0 ? std::min<std::size_t>(bytes.size(), 40) : bytes.size());
      switch (random.below(4)) {
        case 0:
          bytes[at] = static_cast<std::uint8_t>(random.next());
          break;
        case 1:
          bytes[at] ^= static_cast<std::uint8_t>(1u << random.below(8));
          break;
        case 2:
          bytes.resize(at);
          break;
        default:
          bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint8_t>(random.next()));
      }
    }
    if (decoder.decode(bytes) != Refusal::count) {
      ++refused;
      continue;
    }
    ++accepted;
    const Bytes again = encode_again(decoder);
    if (again.size() == bytes.size()) {
      ASSERT_EQ(again, bytes);
    } else {
      ASSERT_LT(again.size(), bytes.size());
    }
  }
  EXPECT_GT(accepted, 20'000u);
  EXPECT_GT(refused, 20'000u);
}

}  // namespace
}  // namespace onemap::comms::wire
