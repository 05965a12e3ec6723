// The parts of a peer that have rules of their own.
#include "peer/peer.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "comms/frontier.hpp"
#include "hash_cache.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;

const LogId kLog{RobotId::from_name("a"), 1, 1}, kOtherLog{RobotId::from_name("b"), 1, 1};
const Instant kMet{10s};

TEST(PeerFrontier, CountsOnlyGrow) {
  PeerFrontier frontier;
  EXPECT_TRUE(frontier.raise(kLog, 3));
  EXPECT_FALSE(frontier.raise(kLog, 2));
  EXPECT_EQ(frontier.count(kLog), 3u);
  EXPECT_EQ(frontier.count(kOtherLog), 0u);
  frontier.claim(kMet, 1, entry_digest(kLog, 3), 0ms);
  EXPECT_FALSE(frontier.next_request());
}

TEST(PeerFrontier, ADifferenceIsRequestedSoonAndThenMoreSeldom) {
  PeerFrontier frontier;
  frontier.claim(kMet, 1, 77, 20ms);
  EXPECT_EQ(frontier.next_request(), kMet + 70ms);
  Instant now = *frontier.next_request();
  for (int k = 0; k < 7; ++k) frontier.requested(now, 20ms);
  EXPECT_EQ(frontier.next_request(), now + 90ms);
  for (int k = 0; k < 20; ++k) frontier.requested(now, 20ms);
  EXPECT_EQ(frontier.next_request(), now + 32 * 90ms);
  frontier.claim(now, 2, 77, 20ms);
  EXPECT_EQ(frontier.next_request(), now + 70ms) << "it speaks";
  frontier.claim(now, 3, 0, 20ms);
  EXPECT_FALSE(frontier.next_request()) << "nothing is what we know of";
}

TEST(PeerFrontier, OvertakenClaimsDoNotCount) {
  PeerFrontier frontier;
  frontier.claim(kMet, 100, 7, 0ms);
  frontier.claim(kMet, 99, 8, 0ms);
  EXPECT_EQ(frontier.claimed_digest(), 7u);
  frontier.claim(kMet, 20, 9, 0ms);
  EXPECT_EQ(frontier.claimed_digest(), 9u) << "so far back it was no overtaking: the peer counts from elsewhere";
}

TEST(PeerFrontier, WhatWasRefusedIsNotRequestedAtEachWord) {
  PeerFrontier frontier;
  frontier.refused_some();
  frontier.claim(kMet, 1, 7, 0ms);
  frontier.requested(*frontier.next_request(), 0ms);
  EXPECT_LT(*frontier.next_request(), kMet + 1s) << "a damaged entry may not be there any more";
  frontier.refused_some();  // by the answer
  const Instant first = *frontier.next_request();
  EXPECT_GE(first, kMet + 4s);
  frontier.claim(kMet + 1s, 2, 7, 0ms);
  EXPECT_EQ(frontier.next_request(), first);
}

TEST(Outbox, WantsWaitForCompanyAndManyDoNot) {
  Outbox box;
  EXPECT_FALSE(box.due(kMet));
  EXPECT_FALSE(box.next());
  box.want({{kLog, 0}, 0, 1}, kMet + 2ms);
  EXPECT_FALSE(box.due(kMet));
  EXPECT_EQ(box.next(), kMet + 2ms);
  EXPECT_TRUE(box.due(kMet + 2ms));
  for (std::size_t k = 0; k < Outbox::kManyWants; ++k) box.want({{kLog, 0}, 0, 1}, kMet + 2ms);
  EXPECT_TRUE(box.due(kMet));
  box.wanted(kMet, 30);
  EXPECT_EQ(box.wants().size(), 3u);
  EXPECT_TRUE(box.due(kMet)) << "what did not fit follows at once";
  box.want_nothing();
  EXPECT_FALSE(box.due(kMet + 1s));
}

TEST(Outbox, TellsEachChangeOnce) {
  Outbox box;
  box.tell(kLog, kMet + 5ms);
  box.tell(kOtherLog, kMet + 50ms);
  EXPECT_FALSE(box.have_due(kMet));
  EXPECT_TRUE(box.have_due(kMet + 5ms));
  box.told(kMet + 5ms, std::vector<wire::HaveEntry>{{kLog, 1}, {kOtherLog, 1}}, 1);
  EXPECT_EQ(box.changed().size(), 1u);
  box.told(kMet + 5ms, std::vector<wire::HaveEntry>{{kOtherLog, 1}}, 1);
  EXPECT_FALSE(box.have_due(kMet + 1s));
  EXPECT_EQ(box.last_have(), kMet + 5ms);
  EXPECT_TRUE(box.may_tell_all(kMet));
  EXPECT_FALSE(box.may_tell_all(kMet + 19ms));
  EXPECT_TRUE(box.may_tell_all(kMet + 20ms));
}

TEST(Outbox, NewsGoesInCopiesWhenItFitsADatagram) {
  Outbox box;
  box.tell(kLog, kMet, true);
  box.told(kMet, std::vector<wire::HaveEntry>{{kLog, 1}}, 1, 3);
  EXPECT_EQ(box.next(), kMet + 4ms);
  box.told(kMet + 4ms, std::vector<wire::HaveEntry>{{kLog, 1}}, 1, 3);
  EXPECT_TRUE(box.have_due(kMet + 8ms));
  box.told(kMet + 8ms, std::vector<wire::HaveEntry>{{kLog, 1}}, 1, 3);
  EXPECT_FALSE(box.have_due(kMet + 1s)) << "three are enough";
  box.tell(kLog, kMet + 1s, true);
  box.tell(kOtherLog, kMet + 1s, true);
  box.told(kMet + 1s, std::vector<wire::HaveEntry>{{kLog, 2}}, 1, 3);
  EXPECT_EQ(box.changed().size(), 1u) << "there is more: no copies";
}

TEST(Outbox, LaterLivesAreToldOnceASecond) {
  Outbox box;
  box.tell_later_life(kMet, 8);
  ASSERT_EQ(box.later_life_due, 8u);
  box.later_life_due.reset();
  box.tell_later_life(kMet + 999ms, 9);
  EXPECT_FALSE(box.later_life_due);
  box.tell_later_life(kMet + 1s, 9);
  EXPECT_EQ(box.later_life_due, 9u);
  // It may be lost: three times again.
  int again = 0;
  for (Instant now = kMet + 1s; now < kMet + 20s; now += 100ms) {
    if (box.later_life_due) ++again;
    box.later_life_due.reset();
    box.tell_later_life_again(now);
  }
  EXPECT_EQ(again, 1 + 3);
  EXPECT_FALSE(box.next()) << "and then no more";
}

TEST(Pings, OnlyTheLastQuestionIsAnsweredAndOnce) {
  Pings pings;
  pings.due = true;
  pings.sent(kMet);
  EXPECT_FALSE(pings.due);
  EXPECT_EQ(pings.next(), kMet + Pings::kGap);
  pings.sent(kMet + 200ms);
  EXPECT_FALSE(pings.answered(kMet + 230ms, 1)) << "the one before";
  EXPECT_EQ(pings.answered(kMet + 230ms, 2), Duration(30ms));
  EXPECT_FALSE(pings.answered(kMet + 240ms, 2));
}

TEST(Session, CountsGoOnWhenAnotherSpeaks) {
  Session session;
  EXPECT_EQ(session.next_header(5, 6), (wire::Header{wire::DatagramType::unicast, 5, 6, 1}));
  Session::Arrival arrival;
  EXPECT_EQ(session.accept({wire::DatagramType::unicast, 6, 5, 9}, arrival), Refusal::count);
  EXPECT_EQ(session.accept({wire::DatagramType::group, 6, 0, 9}, arrival), Refusal::count) << "counted apart";
  EXPECT_FALSE(arrival.unicast);
  EXPECT_EQ(session.accept({wire::DatagramType::unicast, 6, 5, 9}, arrival), Refusal::duplicate);
  EXPECT_EQ(session.accept({wire::DatagramType::unicast, 6, 5, 9000}, arrival), Refusal::counter_jump);
  session.begin_again();
  EXPECT_EQ(session.accept({wire::DatagramType::unicast, 7, 5, 1}, arrival), Refusal::count);
  EXPECT_EQ(session.next_header(5, 7).counter, 2u);
  EXPECT_TRUE(Session::proves({wire::DatagramType::unicast, 7, 5, 1}, 5));
  EXPECT_FALSE(Session::proves({wire::DatagramType::unicast, 7, 4, 1}, 5));
  EXPECT_FALSE(Session::proves({wire::DatagramType::group, 7, 5, 1}, 5));
}

TEST(Peer, BecomesWhoStandsBesideIt) {
  Peer peer(heap());
  SplitMix random(1);
  peer.configured = peer.ever_heard = true;
  peer.bytes_in = 9;
  peer.who = {RobotId::from_name("a"), 5, true, true, kMet};
  peer.frontier.raise(kLog, 3);
  peer.candidates.greeted(kMet, RobotId::from_name("b"), 6, true, random);
  const Candidate* const beside = peer.candidates.next();
  ASSERT_NE(beside, nullptr);
  peer.become(beside->robot, beside->incarnation, heap());
  EXPECT_EQ(peer.who.robot, RobotId::from_name("b"));
  EXPECT_EQ(peer.who.incarnation, 6u);
  EXPECT_FALSE(peer.who.alive || peer.who.proved);
  EXPECT_EQ(peer.frontier.count(kLog), 0u);
  EXPECT_FALSE(peer.candidates.due());
  EXPECT_TRUE(peer.configured && peer.ever_heard);
  EXPECT_EQ(peer.bytes_in, 9u);
}

TEST(HashCache, IsBoundedAndRight) {
  HashCache cache;
  Record record{{kLog, 0}, 4, {1, 2, 3}};
  std::vector<std::uint8_t> payload = {1, 2, 3};
  payload.resize(3 + kSealBytes);
  std::fill_n(payload.begin() + 3 + 32, 4, std::uint8_t{0xFF});  // it replaces nothing
  EXPECT_EQ(cache.of(record), wire::body_hash(4, payload));
  for (std::uint32_t k = 0; k < 5000; ++k) {
    record.id.seq = k;
    cache.of(record);
    ASSERT_LE(cache.size(), HashCache::kCapacity);
  }
}

}  // namespace
}  // namespace onemap::comms
