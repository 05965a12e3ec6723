#include "hal/imaging/registration_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace onemap::hal::imaging {
namespace {

using testing::HasSubstr;

TEST(RegistrationOptions, AreTakenOneByOne) {
  RegistrationOptions options;
  EXPECT_FALSE(options.registration.has_value());
  for (const auto& [word, registration] :
       {std::pair("device", Registration::device), {"ours", Registration::ours}, {"none", Registration::none}}) {
    ASSERT_TRUE(options.set("registration", word).ok()) << word;
    EXPECT_EQ(options.registration, registration);
  }
  ASSERT_TRUE(options.set("baseline", "-0.075").ok());
  EXPECT_EQ(options.baseline_m, -0.075);
  EXPECT_TRUE(options.calibration_source.empty());
  ASSERT_TRUE(options.set("fx", "500").ok());
  EXPECT_EQ(options.calibration_source, "options");
  EXPECT_THAT(options.check().error().reason, HasSubstr("lacks fy cx cy"));
  for (const char* key : {"fy", "cx", "cy"}) ASSERT_TRUE(options.set(key, "300").ok());
  EXPECT_TRUE(options.check().ok());
}

TEST(RegistrationOptions, SayWhyNot) {
  RegistrationOptions options;
  EXPECT_TRUE(options.check().ok()) << "nothing is whole";
  EXPECT_EQ(options.set("registration", "both").error().reason, "registration=both: expected device, ours or none");
  for (const char* baseline : {"", "x", "0.1m", "0.51", "-0.51", "nan"})
    EXPECT_THAT(options.set("baseline", baseline).error().reason, HasSubstr("expected metres from -0.5 to 0.5"));
  EXPECT_THAT(options.set("fx", "-1").error().reason, HasSubstr("fx"));
  for (const char* key : {"registration", "baseline", "calibration", "k3"})
    EXPECT_TRUE(RegistrationOptions::knows(key)) << key;
  EXPECT_FALSE(RegistrationOptions::knows("mode"));
}

TEST(RegistrationOptions, KeysOfTheAddressWinOverTheFile) {
  RegistrationOptions options;
  ASSERT_TRUE(options.set_file("fx 500\nfy 500\ncx 320\ncy 240\n", "kinect.txt").ok());
  ASSERT_TRUE(options.set("calibration", "kinect.txt").ok());
  ASSERT_TRUE(options.set("fx", "510").ok());
  Intrinsics k;
  ASSERT_TRUE(options.calibration.apply(k).ok());
  EXPECT_EQ(k.fx, 510);
  EXPECT_EQ(k.fy, 500);
  EXPECT_EQ(options.calibration_source, "kinect.txt");
  EXPECT_EQ(options.set_file("fx five\n", "bad.txt").error().place, "bad.txt:1");
}

}  // namespace
}  // namespace onemap::hal::imaging
