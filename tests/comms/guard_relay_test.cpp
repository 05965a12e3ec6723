// Somebody between two robots passes on their handshake through an address of his own, and then nothing more
// (comms/PROTOCOL.md, Two ways to one robot).
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

#include "support/guarded.hpp"
#include "support/sim_net.hpp"

namespace onemap::comms::sim {
namespace {

using namespace std::chrono_literals;

// Each of two robots takes it for the other one.
class PassesOnHandshakes final : public Guest {
 public:
  PassesOnHandshakes(Endpoint own, Endpoint a, Endpoint b) : own_(own), a_(a), b_(b) {}
  void hear(Instant now, const Endpoint& from, const Endpoint& to, std::span<const std::uint8_t> bytes) override {
    const auto type = static_cast<sealed::Type>(bytes[1]);
    const bool frames = type == sealed::Type::frames || type == sealed::Type::group;
    if (to != own_ || frames) return;
    waiting_.push_back({from == a_ ? b_ : a_, {bytes.begin(), bytes.end()}});
    next_ = now;
  }
  Instant next() const override { return waiting_.empty() ? Instant::max() : next_; }
  void speak(Instant, const Send& send) override {
    for (; !waiting_.empty(); waiting_.pop_front()) send(own_, waiting_.front().to, waiting_.front().bytes);
  }

 private:
  struct Passed {
    Endpoint to;
    Datagram bytes;
  };
  Endpoint own_, a_, b_;
  Instant next_{};
  std::deque<Passed> waiting_;
};

bool lives_at(const Node& node, const Endpoint& where) {
  const auto all = node.neighbours();
  return std::ranges::any_of(all, [&](const auto& one) { return one.alive && one.endpoint == where; });
}

TEST(GuardRelay, WhoPassesOnAHandshakeAndNothingMorePartsTwoRobotsForSecondsOnly) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SimNet net(seed, {});
    const Endpoint a = SimNet::address(0), b = SimNet::address(1), relay = SimNet::address(2);
    NodeConfig config;
    config.sealed = true;
    config.peers = {relay, b};
    net.add(config);
    config.peers = {a};
    net.add(config);
    net.add(std::make_unique<PassesOnHandshakes>(relay, a, b));
    net.connect(0, 2);
    net.connect(1, 2);
    ASSERT_TRUE(net.run_until([&] { return lives_at(net.node(0), relay) && lives_at(net.node(1), relay); }, 5s));
    for (std::size_t i = 0; i < 2; ++i) net.append(i, 1, 100);
    net.run_for(1s);
    EXPECT_FALSE(net.equal());
    net.connect(0, 1);
    EXPECT_TRUE(net.run_until([&] { return net.equal() && net.node(0).frontier().size() == 2; }, 4s)) << seed;
    EXPECT_TRUE(lives_at(net.node(0), b) && lives_at(net.node(1), a)) << seed;
  }
}

// The same robot at another address: a second handshake of the same life.
struct TwoWays {
  Guarded robot;
  OtherSide first{kTeam}, second{kTeam};
  bool meet_at_both() {
    if (!robot.meet(first, at(100))) return false;
    robot.pass(3s);
    second.hello(robot.now);  // which nobody gets: the next one has other keys than the first side's
    return robot.meet(second, at(300));
  }
  void greet_at_second() { robot.hear(at(300), second.sealed(beacon_of(second.robot()), ++counter)); }
  std::uint32_t counter = 0;
};

TEST(GuardRelay, WhoDoesNotAnswerWhereItWasLivesWhereItIsHeard) {
  TwoWays ways;
  ASSERT_TRUE(ways.meet_at_both());
  EXPECT_TRUE(lives_at(ways.robot.node, at(100))) << "it is asked first";
  EXPECT_GE(ways.robot.refused(Refusal::second_path), 1u);
  ways.robot.pass(500ms);
  ways.greet_at_second();
  EXPECT_FALSE(lives_at(ways.robot.node, at(300))) << "it may still answer";
  ways.robot.pass(200ms);
  ways.greet_at_second();
  EXPECT_TRUE(lives_at(ways.robot.node, at(300)));
}

TEST(GuardRelay, WhoAnswersWhereItWasStaysThere) {
  TwoWays ways;
  ASSERT_TRUE(ways.meet_at_both());
  ways.robot.pass(500ms);
  ways.robot.hear(at(100), ways.first.sealed(beacon_of(ways.first.robot()), 1));
  ways.robot.pass(200ms);
  ways.greet_at_second();
  EXPECT_TRUE(lives_at(ways.robot.node, at(100)));
  EXPECT_FALSE(lives_at(ways.robot.node, at(300)));
}

}  // namespace
}  // namespace onemap::comms::sim
