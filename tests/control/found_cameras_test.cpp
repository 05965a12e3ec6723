#include "control/found_cameras.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "control/words.hpp"

namespace onemap::control {
namespace {

using testing::HasSubstr;

Machine says(std::optional<Told> told, std::string* asked = nullptr) {
  return {"", 0, {}, [=](const std::string& options) {
            if (asked) *asked = options;
            return told;
          }};
}

const std::string kTwo =
    R"({"found":[{"address":"v4l2:/dev/video0","description":"An old one","abilities":"","problem":"no colour node",)"
    R"("limits":""},{"address":"v4l2:/dev/video2","description":"A good one","abilities":"depth Z16 640x480",)"
    R"("problem":"","limits":"is on USB 2"}],"auto":"v4l2:/dev/video2"})";

TEST(FoundCameras, AreWhatOnemapdSaysWhateverItsLibrariesSayBeside) {
  std::string asked;
  const auto found = found_cameras(says(Told{0, "[warning] a driver\n" + kTwo + "\nand more\n"}, &asked));
  ASSERT_TRUE(found.ok()) << found.error().text();
  EXPECT_EQ(asked, "--cameras --json");
  EXPECT_EQ(found_cameras_words(*found),
            "v4l2:/dev/video0\n  An old one\n  cannot be used: no colour node\n"
            "v4l2:/dev/video2\n  A good one\n  depth Z16 640x480\n  limited: is on USB 2\nauto is v4l2:/dev/video2\n");
}

TEST(FoundCameras, WithoutAnAnswerThereIsTheReason) {
  EXPECT_THAT(found_cameras(says(std::nullopt)).error().text(), HasSubstr("not found"));
  EXPECT_THAT(found_cameras(says(Told{Told::kTooLong, ""})).error().text(), HasSubstr("a driver hangs"));
  EXPECT_THAT(found_cameras(says(Told{1, "a\tcrash"})).error().text(), HasSubstr("status 1: a"));
  for (const char* text : {"", "{", "{}", "{\"found\": 3}", "none"})
    EXPECT_FALSE(found_cameras(says(Told{0, text})).ok()) << text;
}

TEST(FoundCameras, StandBesideTheRobotsOwn) {
  Json answer = Json::parse(kTwo);
  answer["cameras"] = Json::array({{{"address", "v4l2:"}, {"limits", "is on USB 2"}, {"missed", 7}, {"unmatched", 8}}});
  EXPECT_THAT(cameras_words(answer),
              testing::AllOf(HasSubstr("camera        v4l2:\n"), HasSubstr("limited       is on USB 2\n"),
                             HasSubstr("7 missed, 8 images without a partner"),
                             HasSubstr("\non this machine:\nv4l2:/dev/video0\n")));
  EXPECT_THAT(cameras_words({{"not_found_because", "no onemapd"}}),
              testing::StrEq("on this machine:\ncannot be told: no onemapd\n"));
}

TEST(FoundCameras, NoneIsSaid) {
  EXPECT_THAT(found_cameras_words({{"found", Json::array()}}), HasSubstr("no camera found"));
  EXPECT_THAT(found_cameras_words(Json::parse(R"({"found":[{"address":"a","problem":"b"}],"auto":null})")),
              testing::EndsWith("none of them can be used\n"));
}

}  // namespace
}  // namespace onemap::control
