#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/backends.hpp"

namespace onemap::hal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

TEST(CameraAddress, Parts) {
  const auto address = parse_camera_address("simulated:living-room?robot=2&seed=7");
  ASSERT_TRUE(address.ok());
  EXPECT_EQ(address->backend, "simulated");
  EXPECT_EQ(address->path, "living-room");
  EXPECT_THAT(address->options, ElementsAre(Pair("robot", "2"), Pair("seed", "7")));
  EXPECT_EQ(address->text, "simulated:living-room?robot=2&seed=7");
}

TEST(CameraAddress, ThePathKeepsItsColons) {
  const auto address = parse_camera_address("replay:/data/fr1:10:20");
  ASSERT_TRUE(address.ok());
  EXPECT_EQ(address->path, "/data/fr1:10:20");
  EXPECT_TRUE(address->options.empty());
}

TEST(CameraAddress, OptionValuesMayBeEmptyOrHoldEquals) {
  const auto address = parse_camera_address("x:?a=&b=c=d");
  ASSERT_TRUE(address.ok());
  EXPECT_EQ(address->path, "");
  EXPECT_THAT(address->options, ElementsAre(Pair("a", ""), Pair("b", "c=d")));
}

TEST(CameraAddress, ErrorsSayWhatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "expected BACKEND:PLACE"},         {"replay", "expected BACKEND:PLACE"},
      {":dir", "expected BACKEND:PLACE"},     {"x:y?fast", "'fast' is not key=value"},
      {"x:y?=1", "'=1' is not key=value"},    {"x:y?a=1&&b=2", "'' is not key=value"},
      {"x:y?a=1&a=2", "'a=2' is given twice"}};
  for (const auto& [text, expected] : cases) {
    const auto address = parse_camera_address(text);
    ASSERT_FALSE(address.ok()) << text;
    EXPECT_THAT(address.error().text(), testing::AllOf(HasSubstr(expected), HasSubstr(text)));
  }
}

TEST(OpenCamera, ChoosesTheBackendOrNamesTheKnownOnes) {
  const Backend table[] = {{"one", "",
                            [](const CameraAddress& a) -> Result<std::unique_ptr<DepthCamera>> {
                              return Error{"one", a.path};
                            }},
                           {"two", "", [](const CameraAddress& a) -> Result<std::unique_ptr<DepthCamera>> {
                              return Error{"two", a.path};
                            }}};
  EXPECT_EQ(open_camera(table, "two:p").error().text(), "two: p");
  EXPECT_THAT(open_camera(table, "three:p").error().text(), HasSubstr("no backend 'three'; known: one, two"));
  EXPECT_THAT(open_camera(table, "p").error().text(), HasSubstr("expected BACKEND:PLACE"));
}

TEST(CheckAddress, AsksTheBackendAndOpensNothing) {
  const Backend table[] = {{"strict", "",
                            [](const CameraAddress&) -> Result<std::unique_ptr<DepthCamera>> {
                              ADD_FAILURE() << "opened";
                              return Error{"", ""};
                            },
                            [](const CameraAddress& a) -> Status {
                              return a.options.empty() ? success() : Error{"strict", "options"};
                            }}};
  EXPECT_TRUE(check_address(table, "strict:p").ok());
  EXPECT_EQ(check_address(table, "strict:p?a=1").error().text(), "strict: options");
  EXPECT_THAT(check_address(table, "other:p").error().text(), HasSubstr("no backend 'other'; known: strict"));
  EXPECT_THAT(check_address(table, "p").error().text(), HasSubstr("expected BACKEND:PLACE"));
}

Result<std::unique_ptr<DepthCamera>> tell_place(const CameraAddress& a) {
  return Error{a.text, std::to_string(a.clock_offset.count())};
}

TEST(OpenCamera, HandsTheClockOffsetOn) {
  const Backend table[] = {{"one", "", tell_place}};
  EXPECT_EQ(open_camera(table, "one:p", Duration(42)).error().text(), "one:p: 42");
  EXPECT_EQ(open_camera(table, "one:p").error().text(), "one:p: 0");
}

TEST(OpenCamera, AutoIsTheFirstUsableCameraInTheTablesOrder) {
  const auto broken = [] { return std::vector<CameraInfo>{{"one:a", "an old one", "", "no permission"}}; };
  const auto good = [] {
    return std::vector<CameraInfo>{{"two:b", "the best", "30 Hz", ""}, {"two:c", "a second", "30 Hz", ""}};
  };
  const Backend table[] = {
      {"named", "", tell_place}, {"one", "", tell_place, nullptr, broken}, {"two", "", tell_place, nullptr, good}};
  EXPECT_EQ(open_camera(table, "auto", Duration(7)).error().text(), "two:b: 7");
  const std::vector<CameraInfo> all = list_cameras(table);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].problem, "no permission");
  EXPECT_EQ(all[2].address, "two:c");
}

TEST(OpenCamera, AutoTakesACameraThatDoesAllThatItCanBeforeALimitedOne) {
  const auto limited = [] {
    return std::vector<CameraInfo>{{"one:a", "", "", "", "is on USB 2"}, {"one:b", "", "", "", "is on USB 2"}};
  };
  const auto whole = [] { return std::vector<CameraInfo>{{"two:c", "", "", ""}}; };
  const Backend table[] = {{"one", "", tell_place, nullptr, limited}, {"two", "", tell_place, nullptr, whole}};
  EXPECT_EQ(open_camera(table, "auto").error().text(), "two:c: 0");
  EXPECT_EQ(open_camera(std::span(table).first(1), "auto").error().text(), "one:a: 0") << "better than none";
}

TEST(OpenCamera, AutoSaysWhyNothingCanBeUsed) {
  const auto broken = [] { return std::vector<CameraInfo>{{"one:a", "an old one", "", "no permission"}}; };
  const Backend table[] = {{"named", "", tell_place}, {"one", "", tell_place, nullptr, broken}};
  EXPECT_EQ(open_camera(table, "auto").error().text(),
            "camera address 'auto': no usable camera on this machine; one:a (an old one): no permission");
  EXPECT_EQ(open_camera(std::span(table).first(1), "auto").error().text(),
            "camera address 'auto': no usable camera on this machine");
}

}  // namespace
}  // namespace onemap::hal
