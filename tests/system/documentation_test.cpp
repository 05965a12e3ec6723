// What people read agrees with what the programs do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "control/ctl.hpp"
#include "daemon/config_key.hpp"
#include "support/other_program.hpp"
#include "support/program.hpp"

namespace onemap {
namespace {

using daemon::ConfigKey;
using testing::HasSubstr;

std::set<std::string> all(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator i(text.begin(), text.end(), regex), end; i != end; ++i) found.insert((*i)[1].str());
  return found;
}

class Documentation : public testing::Test {
 protected:
  // What a program says; it must be content.
  std::string said(const std::string& program, const std::vector<std::string>& arguments) {
    EXPECT_EQ(test::run(program, arguments, folder_ / "said"), 0) << program;
    return test::text_of(folder_ / "said");
  }
  // A man page as people see it: nothing of its language is left.
  static std::string shown(std::string page) {
    page = std::regex_replace(page, std::regex(R"(\\f[BIR])"), "");
    page = std::regex_replace(page, std::regex(R"(\\&)"), "");
    page = std::regex_replace(page, std::regex(R"(\\-)"), "-");
    return std::regex_replace(page, std::regex(R"(\\e)"), "\\");
  }
  const test::TempFolder folder_;
  const std::string readme_ = test::text_of(std::filesystem::path(ONEMAP_SOURCE_DIR) / "README.md");
};

TEST_F(Documentation, TheManPageOfTheConfigurationHasEveryKeyWithItsDefaultAndRange) {
  const std::string page = shown(said("onemapd", {"--man", "5"}));
  for (const ConfigKey& key : daemon::config_keys()) {
    const std::string entry =
        ".TP\n" + std::string(key.name) + " = " + daemon::toml_text(key.get({})) + "\n" + key.text;
    EXPECT_THAT(page, HasSubstr(entry));
    EXPECT_THAT(page, HasSubstr("Accepted: " + key.values));
  }
  for (const daemon::ConfigSection& section : daemon::config_sections())
    EXPECT_THAT(page, HasSubstr(".SS [" + std::string(section.name) + "]\n"));
}

TEST_F(Documentation, TheManPageOfTheDaemonHasEveryOptionOfItsHelp) {
  const std::string page = shown(said("onemapd", {"--man", "8"})), help = said("onemapd", {"--help"});
  const std::string option = R"((--[a-z][-a-z]+))";
  const auto of_help = all(help, option);
  EXPECT_GE(of_help.size(), 15u);
  auto of_page = all(page, option);
  of_page.erase("--now");  // systemctl's
  EXPECT_EQ(of_page, of_help) << "none more and none less";
  for (const std::string& name : of_help) EXPECT_EQ(all(page, "\\n(?:-h,)?(" + name + ")[ \\n]").size(), 1u) << name;
}

TEST_F(Documentation, EverySharedLibraryOfTheDaemonIsNamedInArchitectureMd) {
  if (std::string_view(ONEMAP_SANITIZE) != "") GTEST_SKIP() << "sanitizers load libraries of their own";
  const std::string text = test::text_of(std::filesystem::path(ONEMAP_SOURCE_DIR) / "ARCHITECTURE.md");
  const std::size_t at = text.find("### What `onemapd` loads");
  ASSERT_NE(at, std::string::npos);
  const std::string list = text.substr(at, text.find("\n## ", at) - at);
  const auto named = all(list, R"(\b(lib[A-Za-z0-9_+.-]*[A-Za-z0-9_+]))");
  const auto loaded = all(test::say("ldd " ONEMAP_BIN_DIR "/onemapd").output, R"(\s(lib[^\s]+?)\.so[.0-9]*\s)");
  EXPECT_GE(loaded.size(), 5u);
  for (const std::string& library : loaded) EXPECT_TRUE(named.contains(library)) << library;
}

TEST_F(Documentation, ManPagesAreWellFormed) {
  if (test::say("man --version").status != 0)
    GTEST_SKIP() << "man is missing (Debian: man-db): the pages were not formatted";
  const std::filesystem::path written = std::filesystem::path(ONEMAP_SOURCE_DIR) / "share/man";
  std::vector<std::string> pages{written / "onemapctl.1", written / "onemap-control.7"};
  for (const char* section : {"5", "8"}) {
    folder_.write(section, said("onemapd", {"--man", section}));
    pages.push_back(folder_ / section);
  }
  for (const std::string& page : pages) {
    const std::string command = "LC_ALL=C.UTF-8 MANWIDTH=80 man --warnings -E UTF-8 -l '" + page + "' >/dev/null";
    EXPECT_EQ(test::say(command).output, "") << page;
  }
}

TEST_F(Documentation, TheReadmeNamesOnlyOptionsThatThereAre) {
  std::string helps;
  for (const char* program : {"onemapd", "onemap-fleet", "onemap-view", "onemap-eval", "onemap-calibrate", "onemapctl"})
    helps += said(program, {"--help"});
  for (const char* command : {"pose", "snapshot", "team", "calibrate"}) helps += said("onemapctl", {command, "--help"});
  for (const char* command : {"init", "show", "join"}) helps += said("onemapctl", {"team", command, "--help"});
  const auto known = all(helps, R"((--[a-z][-a-z]+))");
  // A line of a command and those that it goes on in.
  for (const std::string& command :
       all(readme_, R"(\n((?:onemapd|onemapctl|onemap-(?:fleet|view|eval|calibrate))\b(?:[^\n]*\\\n)*[^\n]*))"))
    for (const std::string& option : all(command, R"((?:^|\s)(--[a-z][-a-z]+))"))
      EXPECT_TRUE(known.contains(option)) << option << " in\n" << command;
}

TEST_F(Documentation, TheReadmeNamesOnlyCommandsOfOnemapctlThatThereAre) {
  const auto commands = control::ctl_commands();
  const auto named = all(readme_, R"(\bonemapctl(?: --[a-z]+)* ([a-z]+))");
  EXPECT_GE(named.size(), 3u);
  for (const std::string& command : named) EXPECT_EQ(std::ranges::count(commands, command), 1) << command;
}

TEST_F(Documentation, TheManPageOfOnemapctlHasEveryOptionOfCalibrate) {
  const std::string page = shown(test::text_of(std::filesystem::path(ONEMAP_SOURCE_DIR) / "share/man/onemapctl.1"));
  const auto options = all(said("onemap-calibrate", {"--help"}), R"((--[a-z][-a-z]+))");
  EXPECT_GE(options.size(), 6u);
  for (const std::string& option : options) EXPECT_THAT(page, HasSubstr(option));
}

TEST_F(Documentation, TheReadmeNamesOnlyKeysThatThereAre) {
  std::string sections;
  for (const daemon::ConfigSection& section : daemon::config_sections())
    sections += (sections.empty() ? "" : "|") + std::string(section.name);
  int keys = 0;
  for (const std::string& name : all(readme_, "`((?:" + sections + ")\\.[a-z_]+)`")) {
    if (name == "map.pgm" || name == "map.yaml" || name == "team.png") continue;  // files
    ++keys;
    const std::size_t dot = name.find('.');
    EXPECT_NE(daemon::find_key(name.substr(0, dot), name.substr(dot + 1)), nullptr) << name;
  }
  EXPECT_GE(keys, 1);
}

TEST_F(Documentation, TheReadmesServiceIsTheOneThatIsInstalled) {
  const std::size_t at = readme_.find("## As a service");
  ASSERT_NE(at, std::string::npos);
  const std::string text = readme_.substr(at, readme_.find("\n## ", at + 1) - at);
  const std::filesystem::path root(ONEMAP_SOURCE_DIR);
  const std::string unit = test::text_of(root / "systemd/common.in");
  for (const char* word : {"onemapd@NAME", "/etc/onemap/onemap.toml", "man onemap.toml", "SIGHUP"})
    EXPECT_THAT(text, HasSubstr(word));
  for (const std::string& setting : all(text, R"(`([A-Z][A-Za-z]+=[^`]*)`)"))
    EXPECT_THAT(unit, HasSubstr("\n" + setting + "\n"));
}

}  // namespace
}  // namespace onemap
