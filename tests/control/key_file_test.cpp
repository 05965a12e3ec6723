#include "control/key_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "comms/fingerprint.hpp"
#include "control/team_commands.hpp"
#include "support/temp_folder.hpp"
#include "support/text_of.hpp"

namespace onemap::control {
namespace {

using testing::HasSubstr;
using testing::Not;

mode_t mode_of(const std::filesystem::path& file) {
  struct stat found {};
  EXPECT_EQ(stat(file.c_str(), &found), 0) << file;
  return found.st_mode & 07777u;
}

TEST(KeyFile, WhatIsWrittenIsReadAndNobodyElseMay) {
  const test::TempFolder folder;
  const auto secret = new_secret();
  ASSERT_TRUE(secret.ok());
  const mode_t before = umask(0);
  const auto written = write_secret(folder / "k", kTeamKeyKind, *secret, Replace::no);
  umask(before);
  ASSERT_TRUE(written.ok()) << written.error().text();
  EXPECT_EQ(mode_of(folder / "k"), 0600u);
  const auto read = read_secret(folder / "k", kTeamKeyKind);
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(*read, *secret);
  EXPECT_FALSE(*new_secret() == *secret);
  EXPECT_EQ(folder.entries(), 1u) << "no temporary one is left";
}

TEST(KeyFile, AFileThatOthersMayUseIsRefused) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_secret(folder / "k", kTeamKeyKind, *new_secret(), Replace::no).ok());
  for (const mode_t mode : {0640u, 0604u, 0620u, 0601u, 0644u, 0666u}) {
    ASSERT_EQ(chmod((folder / "k").c_str(), mode), 0);
    const auto read = read_secret(folder / "k", kTeamKeyKind);
    ASSERT_FALSE(read.ok()) << std::oct << mode;
    EXPECT_THAT(read.error().text(), HasSubstr("chmod 600 " + folder / "k"));
  }
  ASSERT_EQ(chmod((folder / "k").c_str(), 0400), 0);
  EXPECT_TRUE(read_secret(folder / "k", kTeamKeyKind).ok());
}

TEST(KeyFile, WhatIsNoKeyIsRefused) {
  const test::TempFolder folder;
  const std::string digits(64, 'a');
  for (const std::string& text :
       {std::string(), std::string("x"), digits, "onemap-team-key-1 " + digits + "0",
        "onemap-team-key-1 " + digits.substr(1), "onemap-team-key-1  " + digits.substr(1),
        "onemap-identity-1 " + digits, "onemap-team-key-1 " + std::string(64, '0'),
        "onemap-team-key-1 " + std::string(64, 'g'), "onemap-team-key-1 " + digits + "\nmore"}) {
    folder.write("k", text);
    ASSERT_EQ(chmod((folder / "k").c_str(), 0600), 0);
    EXPECT_FALSE(read_secret(folder / "k", kTeamKeyKind).ok()) << text;
  }
  EXPECT_FALSE(read_secret(folder / "absent", kTeamKeyKind).ok());
  EXPECT_FALSE(read_secret(folder.path().string(), kTeamKeyKind).ok());
}

TEST(KeyFile, AKeyThatIsThereStays) {
  const test::TempFolder folder;
  const auto first = *new_secret(), second = *new_secret();
  ASSERT_TRUE(write_secret(folder / "k", kTeamKeyKind, first, Replace::no).ok());
  EXPECT_THAT(write_secret(folder / "k", kTeamKeyKind, second, Replace::no).error().reason,
              HasSubstr("is there already"));
  EXPECT_EQ(*read_secret(folder / "k", kTeamKeyKind), first);
  ASSERT_TRUE(write_secret(folder / "k", kTeamKeyKind, second, Replace::yes).ok());
  EXPECT_EQ(*read_secret(folder / "k", kTeamKeyKind), second);
}

TEST(TeamCommands, InitShowJoin) {
  const test::TempFolder folder;
  TeamOptions one, two;
  one.file = folder / "one";
  two.file = folder / "two";
  const auto made = team_init(one);
  ASSERT_TRUE(made.ok()) << made.error().text();
  EXPECT_THAT(team_init(one).error().text(), HasSubstr("--force"));
  const auto shown = team_show(one);
  const std::string fingerprint = comms::fingerprint(*read_secret(one.file, kTeamKeyKind));
  EXPECT_THAT(shown->words, HasSubstr(fingerprint));
  one.secret = true;
  const auto secret = team_show(one);
  const std::string key = secret->words;
  EXPECT_THAT(key, HasSubstr("onemap-team-key-1 "));
  EXPECT_EQ(secret->json.value("key", "") + "\n", key);
  for (const auto& said : {made, shown}) {
    EXPECT_THAT(said->words, Not(HasSubstr(key.substr(20, 60)))) << "never the key unless asked";
    EXPECT_THAT(said->json.dump(), Not(HasSubstr(key.substr(20, 60))));
  }
  const auto joined = team_join(two, key);
  ASSERT_TRUE(joined.ok()) << joined.error().text();
  EXPECT_THAT(joined->words, HasSubstr(fingerprint));
  EXPECT_EQ(joined->json, (Json{{"class", "TEAM"}, {"file", two.file}, {"fingerprint", fingerprint}}));
  EXPECT_EQ(mode_of(two.file), 0600u);
  EXPECT_EQ(test::text_of(two.file), test::text_of(one.file));
  EXPECT_FALSE(team_join(two, "nonsense").ok());
  EXPECT_FALSE(team_join(two, key).ok()) << "there is one";
}

}  // namespace
}  // namespace onemap::control
