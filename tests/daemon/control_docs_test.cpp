// What people are told of the control protocol and of onemapctl is what the programs know.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "control/ctl.hpp"
#include "daemon/control/control_actions.hpp"
#include "daemon/control/replies.hpp"
#include "daemon/control/robot_facts.hpp"
#include "support/text_of.hpp"

namespace onemap::daemon {
namespace {

const std::string kShare = std::string(ONEMAP_SOURCE_DIR) + "/share/";

// The page as people read it: without its commands, and with its own hyphens.
std::string page(const std::string& name) {
  std::string text = test::text_of(kShare + "man/" + name);
  EXPECT_FALSE(text.empty()) << name;
  for (std::size_t at = 0; (at = text.find("\\-", at)) != std::string::npos;) text.erase(at, 1);
  return text;
}

// Whether it stands there by itself, and not within another word.
bool has_word(const std::string& text, const std::string& word) {
  const auto inside = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += word.size())
    if ((at == 0 || !inside(text[at - 1])) && !inside(text[at + word.size()])) return true;
  return false;
}

TEST(ControlDocs, EveryRequestAndItsKeysStandInTheManPage) {
  const std::string text = page("onemap-control.7");
  for (const Command& command : control_commands({}, {})) {
    EXPECT_NE(text.find("\n.B " + std::string(command.name) + "\n"), std::string::npos) << command.name;
    for (const std::string_view key : command.keys)
      EXPECT_TRUE(has_word(text, std::string(key))) << command.name << "." << key;
  }
  for (const char* name : {"VERSION", "ERROR", "ACK", "DONE", "EVENT"}) EXPECT_TRUE(has_word(text, name)) << name;
  for (const std::string_view name : kWatchable) EXPECT_TRUE(has_word(text, std::string(name))) << name;
  EXPECT_TRUE(has_word(text, std::to_string(control::kMostLineBytes)));
  EXPECT_TRUE(has_word(text, std::to_string(control::kMostClients)));
  EXPECT_TRUE(has_word(text, std::to_string(control::kMostUnread >> 10)));
}

void expect_keys(const std::string& text, const Json& object) {
  if (object.is_array())
    for (const Json& item : object) expect_keys(text, item);
  if (!object.is_object()) return;
  for (const auto& [key, value] : object.items()) {
    EXPECT_TRUE(has_word(text, key)) << key;
    expect_keys(text, value);
  }
}

TEST(ControlDocs, EveryKeyOfAnAnswerStandsInTheManPage) {
  const std::string text = page("onemap-control.7");
  RobotFacts facts;
  facts.radio.neighbours.resize(1);
  facts.radio.last_sign[RobotId::from_name("r2")] = {};
  facts.pipeline.look = DepthLook{};
  facts.status.T_map_odom = mapping::Pose{};
  mapping::Why why;
  why.way.resize(1);
  why.pairs.resize(1);
  why.pairs[0].link.emplace();
  why.pairs[0].ruling.emplace();
  for (const Json& answer :
       {why_json(why), status_json(facts), peers_json(facts), consensus_json(facts), map_json(facts),
        cameras_json(facts), doctor_json(facts), pose_json({}, std::nullopt), greeting_json("r", "1")})
    expect_keys(text, answer);
}

TEST(ControlDocs, EveryEventStandsInTheManPage) {
  const std::string text = page("onemap-control.7");
  const std::vector<mapping::TeamEvent> all{
      mapping::RobotJoined{}, mapping::RobotFinished{}, mapping::RobotGone{},     mapping::RobotBack{},
      mapping::LinkLooked{},  mapping::PairRuled{},     mapping::RecordRefused{}, mapping::DeciderPassedOver{},
      mapping::MapFused{},    mapping::MapSettled{}};
  EXPECT_EQ(all.size(), std::variant_size_v<mapping::TeamEvent>) << "a new event: tell people of it";
  for (const auto& event : all) {
    const Json object = event_json(event);
    EXPECT_TRUE(has_word(text, object.value("event", "?"))) << object.dump();
    expect_keys(text, object);
  }
}

TEST(ControlDocs, EverySubcommandIsInItsManPageAndInEveryCompletion) {
  const std::string man = page("onemapctl.1");
  const auto commands = control::ctl_commands();
  EXPECT_GE(commands.size(), 14u);
  for (const std::string& command : commands) {
    EXPECT_TRUE(std::ranges::any_of(
        std::vector<std::string>{".B ", ".BI ", ".BR ", ".BR \""},
        [&](const std::string& before) { return man.find("\n" + before + command) != std::string::npos; }))
        << command;
    for (const char* file : {"onemapctl.bash", "_onemapctl", "onemapctl.fish"})
      EXPECT_TRUE(has_word(test::text_of(kShare + "completions/" + file), command)) << command << " in " << file;
  }
}

TEST(ControlDocs, EveryOptionIsInTheManPageAndInEveryCompletion) {
  const std::string man = page("onemapctl.1");
  auto options = control::ctl_options();
  EXPECT_GE(options.size(), 11u);
  options.insert(options.end(), {"from", "out", "baseline", "images"});  // onemap-calibrate's
  for (const std::string& option : options) {
    EXPECT_NE(man.find("--" + option), std::string::npos) << option;
    for (const char* file : {"onemapctl.bash", "_onemapctl", "onemapctl.fish"})
      EXPECT_TRUE(has_word(test::text_of(kShare + "completions/" + file), option)) << option << " in " << file;
  }
}

TEST(ControlDocs, BashCompletesCommandsAndWhatFollowsThem) {
  const auto completes = [](const std::string& words) {
    const std::string script = "source " + kShare + "completions/onemapctl.bash; COMP_WORDS=(onemapctl " + words +
                               "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _onemapctl; echo \"${COMPREPLY[*]}\"";
    std::FILE* bash = popen(("bash -c '" + script + "'").c_str(), "r");
    std::array<char, 4096> out{};
    const std::size_t got = std::fread(out.data(), 1, out.size(), bash);
    EXPECT_EQ(pclose(bash), 0) << words;
    return std::string(out.data(), got);
  };
  EXPECT_EQ(completes("st"), "status\n");
  EXPECT_EQ(completes("--socket x un"), "unmerge\n");
  EXPECT_EQ(completes("record st"), "start stop\n");
  EXPECT_EQ(completes("watch P"), "POSE PEERS\n");
  EXPECT_EQ(completes("snapshot --kind p"), "png plan\n");
  EXPECT_EQ(completes("pose --f"), "--follow\n");
}

// The shell itself reads its completion.
class Completion : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(Completion, IsWellFormed) {
  const auto [shell, file] = GetParam();
  if (std::system(fmt::format("command -v {} >/dev/null", shell).c_str()) != 0)
    GTEST_SKIP() << shell << " is missing (Debian: " << shell << "): its completion was not read";
  const std::string script = kShare + "completions/" + file;
  EXPECT_EQ(std::system(fmt::format("{} -n '{}'", shell, script).c_str()), 0) << script;
  EXPECT_NE(std::system(fmt::format("echo 'if (' | {} -n 2>/dev/null", shell).c_str()), 0) << "it sees what is wrong";
}

INSTANTIATE_TEST_SUITE_P(Shells, Completion,
                         testing::Values(std::pair{"bash", "onemapctl.bash"}, std::pair{"zsh", "_onemapctl"},
                                         std::pair{"fish", "onemapctl.fish"}),
                         [](const auto& shell) { return std::string(shell.param.first); });

TEST(ControlDocs, EveryRequestHasItsSubcommand) {
  const auto known = control::ctl_commands();
  for (const Command& command : control_commands({}, {})) {
    std::string lower(command.name);
    std::ranges::transform(lower, lower.begin(), [](char c) { return static_cast<char>(std::tolower(c)); });
    EXPECT_TRUE(std::ranges::find(known, lower) != known.end()) << command.name;
  }
}

}  // namespace
}  // namespace onemap::daemon
