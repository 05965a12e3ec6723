#include "daemon/control/control_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <thread>

#include "support/control_talk.hpp"
#include "support/temp_folder.hpp"

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;
using control::kMostClients;
using test::Talk;
using testing::HasSubstr;

// A server on a thread of its own, with a few commands.
struct ControlServerTest : testing::Test {
  const test::TempFolder folder;
  const std::string path = folder / "control.sock";
  Log log{"test"};
  std::unique_ptr<EventLoop> loop = EventLoop::open().value();
  std::unique_ptr<ControlServer> server;
  std::deque<Later> waiting;  // of SLOW
  std::thread thread;

  std::vector<Command> commands() {
    return {
        {"ECHO",
         Effect::reads,
         {"text"},
         "",
         [](const Request& r) -> Result<Json> {
           return Json{{"text", r.object.value("text", "")}};
         }},
        {"FAIL",
         Effect::reads,
         {},
         "",
         [](const Request&) -> Result<Json> {
           return Error{"", "it cannot be"};
         }},
        {"THROW", Effect::reads, {}, "", [](const Request&) -> Result<Json> { throw std::runtime_error("thrown"); }},
        {"CHANGE", Effect::changes, {}, "", [](const Request&) -> Result<Json> { return Json::object(); }},
        {"BIG",
         Effect::reads,
         {},
         "",
         [](const Request&) -> Result<Json> {
           return Json{{"text", std::string(1 << 20, 'x')}};
         }},
        {"HEAR",
         Effect::reads,
         {},
         "",
         [](const Request& r) -> Result<Json> { return r.watched.insert("NEWS"), Json::object(); }},
        {"SLOW",
         Effect::reads,
         {},
         "",
         [this](const Request& r) -> Result<Json> { return waiting.push_back(r.later()), Json::object(); }},
    };
  }
  void SetUp() override {
    server = std::make_unique<ControlServer>(*loop, commands(), Json{{"class", "VERSION"}, {"protocol", 1}}, log);
    auto listener = Listener::at_path(path);
    ASSERT_TRUE(listener.ok()) << listener.error().text();
    ASSERT_TRUE(server->serve(std::move(*listener)).ok());
    thread = std::thread([this] { loop->run(); });
  }
  void TearDown() override {
    loop->stop();
    thread.join();
    server.reset();
    EXPECT_FALSE(std::filesystem::exists(path)) << "the socket is taken away";
  }
  // On the loop's thread.
  void there(const std::function<void()>& what) {
    std::mutex mutex;
    std::condition_variable wake;
    bool done = false;
    loop->post([&] {
      what();
      const std::lock_guard lock(mutex);
      done = true;
      wake.notify_one();
    });
    std::unique_lock lock(mutex);
    wake.wait(lock, [&] { return done; });
  }
  ControlCounters counters() {
    ControlCounters copy;
    there([&] { copy = server->counters(); });
    return copy;
  }
  std::size_t clients() {
    std::size_t count = 0;
    there([&] { count = server->clients(); });
    return count;
  }
  Talk greeted() {
    Talk talk(path);
    EXPECT_EQ(talk.hear().value("class", ""), "VERSION");
    return talk;
  }
};

TEST_F(ControlServerTest, GreetsAndAnswersWithTheClassAndTheId) {
  Talk talk = greeted();
  talk.ask(R"({"class":"ECHO","text":"a","id":7})");
  EXPECT_EQ(talk.hear().dump(), R"({"class":"ECHO","id":7,"text":"a"})");
  talk.ask(R"({"class":"CHANGE","id":"x"})");
  EXPECT_EQ(talk.hear().dump(), R"({"class":"CHANGE","id":"x"})") << "of the daemon's own user";
}

TEST_F(ControlServerTest, WhatIsWrongIsSaidAndLosesNothing) {
  Talk talk = greeted();
  const std::pair<std::string, std::string> wrong[] = {
      {"{", "no JSON"},
      {"[1]", "expected a JSON object"},
      {"{}", "expected a \"class\": ECHO, FAIL"},
      {R"({"class":3})", "expected a \"class\""},
      {R"({"class":"ECO"})", "unknown class 'ECO'; known: ECHO"},
      {R"({"class":"ECHO","txt":1})", "ECHO has no key 'txt'; it has text"},
      {R"({"class":"FAIL","text":1})", "FAIL has no key 'text'; it has none"},
      {R"({"class":"ECHO","id":[]})", "id: expected"},
      {R"({"class":"FAIL"})", "it cannot be"},
      {R"({"class":"THROW"})", "thrown"},
      {std::string("\0\xff\xfe", 3), "no JSON"},
      {R"({"class":"\u001b[31m"})", "unknown class '\\x1b[31m'"},
      {std::string(5000, '['), "at most 4096 bytes"},
      {std::string(4000, '['), "no JSON"},
  };
  for (const auto& [line, why] : wrong) {
    talk.ask(line);
    const Json error = talk.hear();
    EXPECT_EQ(error.value("class", ""), "ERROR") << line;
    EXPECT_THAT(error.value("message", ""), HasSubstr(why)) << line;
  }
  talk.ask(R"({"class":"ECHO","text":"still here"})");
  EXPECT_EQ(talk.hear().value("text", ""), "still here");
  const auto counted = counters().errors;
  EXPECT_EQ(counted.at("too_long"), 1u);
  EXPECT_EQ(counted.at("bad_json"), 3u);
  EXPECT_EQ(counted.at("bad_request"), 8u);
  EXPECT_EQ(counted.at("failed"), 2u);
}

TEST_F(ControlServerTest, LinesThatComeTogetherOrInPiecesAreAnsweredInOrder) {
  Talk talk = greeted();
  std::string all;
  for (int i = 0; i < 500; ++i) all += R"({"class":"ECHO","id":)" + std::to_string(i) + "}\n";
  talk.say(all.substr(0, 1000));
  std::this_thread::sleep_for(20ms);
  talk.say(all.substr(1000));
  shutdown(talk.fd(), SHUT_WR);
  for (int i = 0; i < 500; ++i) ASSERT_EQ(talk.hear().value("id", -1), i);
  EXPECT_TRUE(talk.is_closed()) << "all was answered, and nothing more is asked";
}

TEST_F(ControlServerTest, LongJobsAreAcknowledgedAndAnsweredLater) {
  Talk talk = greeted();
  talk.ask(R"({"class":"SLOW","id":1})");
  EXPECT_EQ(talk.hear().dump(), R"({"class":"ACK","id":1,"of":"SLOW"})");
  talk.ask(R"({"class":"SLOW","id":2})");
  EXPECT_EQ(talk.hear().value("id", 0), 2);
  talk.ask(R"({"class":"ECHO"})");
  EXPECT_EQ(talk.hear().value("class", ""), "ECHO") << "nobody waits for it";
  std::thread([&] { waiting.front()(Json{{"made", "it"}}); }).join();
  EXPECT_EQ(talk.hear().dump(), R"({"class":"DONE","id":1,"of":"SLOW","made":"it"})");
  waiting.back()(Error{"disk", "full"});
  EXPECT_EQ(talk.hear().dump(), R"({"class":"ERROR","id":2,"message":"disk: full"})");
}

TEST_F(ControlServerTest, AnAnswerForSomebodyWhoLeftGoesNowhere) {
  {
    Talk talk = greeted();
    talk.ask(R"({"class":"SLOW"})");
    EXPECT_EQ(talk.hear().value("class", ""), "ACK");
  }
  while (clients() > 0) std::this_thread::sleep_for(5ms);
  waiting.front()(Json::object());
  EXPECT_EQ(clients(), 0u);
}

TEST_F(ControlServerTest, NewsGoToThoseWhoWantThem) {
  Talk hears = greeted(), does_not = greeted();
  hears.ask(R"({"class":"HEAR"})");
  hears.hear();
  int made = 0;
  there([&] { server->tell("NEWS", [&] { return ++made, Json{{"n", made}}; }); });
  EXPECT_EQ(hears.hear().dump(), R"({"class":"NEWS","n":1})");
  EXPECT_EQ(made, 1);
  does_not.ask(R"({"class":"ECHO"})");
  EXPECT_EQ(does_not.hear().value("class", ""), "ECHO");
  there([&] {
    EXPECT_TRUE(server->watches("NEWS"));
    server->tell("OTHER", [&] { return ++made, Json(); });
  });
  EXPECT_EQ(made, 1) << "nobody wanted it";
}

TEST_F(ControlServerTest, WhoDoesNotReadIsDroppedAndTheOthersHearEverything) {
  Talk never = greeted(), reads = greeted();
  for (Talk* talk : {&never, &reads}) {
    talk->ask(R"({"class":"HEAR"})");
    talk->hear();
  }
  const std::string text(8000, 'x');
  for (int i = 0; i < 200; ++i) {  // 1.6 MB, more than the kernel and the daemon keep
    there([&] { server->tell("NEWS", [&] { return Json{{"n", i}, {"text", text}}; }); });
    ASSERT_EQ(reads.hear().value("n", -1), i);
  }
  EXPECT_EQ(counters().dropped.at("slow"), 1u);
  EXPECT_EQ(clients(), 1u);
  EXPECT_TRUE(never.is_closed());
}

TEST_F(ControlServerTest, WhoAsksAndDoesNotReadIsReadNoFurtherAndDroppedInTheEnd) {
  Talk rude = greeted(), polite = greeted();
  const timeval limit{0, 200'000};
  setsockopt(rude.fd(), SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  std::string many;
  for (int i = 0; i < 100; ++i) many += "{\"class\":\"BIG\"}\n";
  for (int i = 0; i < 1000 && rude.say(many); ++i) {
  }
  EXPECT_LT(counters().requests, 10u) << "a hundred megabytes were asked for at first";
  for (int i = 0; i < 100; ++i) {
    polite.ask(R"({"class":"ECHO"})");
    ASSERT_EQ(polite.hear().value("class", ""), "ECHO");
  }
  EXPECT_EQ(clients(), 2u);
  const auto end = std::chrono::steady_clock::now() + test::kPatience * 60s;
  while (clients() > 1 && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(50ms);
  EXPECT_EQ(counters().dropped.at("stalled"), 1u);
  polite.ask(R"({"class":"BIG"})");
  EXPECT_EQ(polite.hear().value("text", "").size(), std::size_t{1} << 20) << "an answer is never cut";
}

TEST_F(ControlServerTest, WhoNeverSpeaksMakesRoomAndWhoSpeaksStays) {
  std::deque<Talk> silent;
  for (std::size_t i = 0; i < kMostClients; ++i) silent.push_back(greeted());
  Talk speaks = greeted();
  speaks.ask(R"({"class":"ECHO"})");
  EXPECT_EQ(speaks.hear().value("class", ""), "ECHO");
  EXPECT_EQ(clients(), kMostClients);
  EXPECT_EQ(counters().dropped.at("crowded_out"), 1u);
  EXPECT_TRUE(silent.front().is_closed()) << "the first who came";
  for (std::size_t i = 1; i < kMostClients; ++i) {
    silent[i].ask(R"({"class":"ECHO"})");
    ASSERT_EQ(silent[i].hear().value("class", ""), "ECHO");
  }
  Talk late(path);
  const Json full = late.hear();
  EXPECT_EQ(full.value("class", ""), "ERROR");
  EXPECT_THAT(full.value("message", ""), HasSubstr("no room"));
  EXPECT_TRUE(late.is_closed());
  EXPECT_EQ(counters().dropped.at("too_many"), 1u);
}

}  // namespace
}  // namespace onemap::daemon
