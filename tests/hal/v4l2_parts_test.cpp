// The parts of the v4l2 backend that need no device.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "address.hpp"
#include "device.hpp"
#include "formats.hpp"
#include "hal/imaging/register_depth.hpp"
#include "hal/imaging/rig_calibration.hpp"
#include "models.hpp"

namespace onemap::hal::v4l2 {
namespace {

using testing::HasSubstr;

TEST(V4l2Formats, DepthIsZ16AndY16OnlyWhenNamed) {
  const FourCc many[] = {kYuyv, kY16, kZ16}, infrared[] = {kGrey, kY16};
  EXPECT_EQ(depth_format(many, false), kZ16);
  EXPECT_EQ(depth_format(infrared, false), 0u);
  EXPECT_EQ(depth_format(infrared, true), kY16);
  EXPECT_EQ(depth_format({}, true), 0u);
}

TEST(V4l2Formats, TheBestColourIsChosen) {
  const FourCc all[] = {kGrey, kMjpeg, kZ16, kUyvy, kYuyv}, few[] = {kGrey, kMjpeg}, none[] = {kZ16};
  EXPECT_EQ(colour_format(all), kYuyv);
  EXPECT_EQ(colour_format(few), kMjpeg);
  EXPECT_EQ(colour_format(none), 0u);
  EXPECT_LT(colour_rank(kYuyv), colour_rank(kMjpeg));
  EXPECT_LT(colour_rank(kGrey), colour_rank(0));
}

TEST(V4l2Formats, NamesAreReadable) {
  EXPECT_EQ(text_of(kZ16), "Z16");
  EXPECT_EQ(text_of(kMjpeg), "MJPG");
  EXPECT_EQ(text_of(0x41000A42u), "B..A");
}

TEST(V4l2Formats, EveryColourFormatIsDecodedAndOthersAreErrors) {
  std::vector<std::uint8_t> raw(2 * 16 * 8, 128), rgb(3 * 16 * 8);
  for (const FourCc format : {kYuyv, kUyvy, kGrey}) EXPECT_TRUE(decode_colour(format, {raw, {16, 8}}, rgb).ok());
  EXPECT_THAT(decode_colour(kMjpeg, {raw, {16, 8}}, rgb).error().reason, HasSubstr("neither PNG nor JPEG"));
  EXPECT_THAT(decode_colour(kZ16, {raw, {16, 8}}, rgb).error().reason, HasSubstr("no decoder for Z16"));
}

TEST(V4l2Models, EveryShippedCalibrationIsGood) {
  for (const char* id : {"8086:0b07", "8086:0b3a", "8086:0ad3", "8086:0b5c", "2bc5:0670", "2bc5:0660", "2bc5:0669"}) {
    const auto models = find_models(id);
    EXPECT_EQ(models.size(), std::string_view(id).starts_with("8086") ? 3u : 1u) << id;
    for (const Model* model : models) {
      const auto rig = imaging::parse_rig_calibration(model->calibration, std::string(model->name));
      ASSERT_TRUE(rig.ok()) << rig.error().text();
      EXPECT_TRUE(rig->depth.has_value()) << model->name;
      EXPECT_LT(rig->noise.sigma_m(1.0), 0.01);
      // The middle of a colour image before a wall is filled by the depth image's, about where that looks.
      imaging::DepthRegistration registration(*rig->depth, rig->colour, rig->pose, rig->depth_offset_m);
      const std::vector<std::uint16_t> wall(imaging::size_of(*rig->depth).pixels(), 2000);
      std::vector<std::uint16_t> seen(imaging::size_of(rig->colour).pixels());
      const auto counts = registration.apply(wall, seen);
      EXPECT_NEAR(seen[seen.size() / 2 + static_cast<std::size_t>(rig->colour.width) / 2], 2000, 60) << model->name;
      EXPECT_LT(counts.outside, counts.readings * 7 / 10) << model->name;
    }
  }
  EXPECT_TRUE(find_models("0000:0000").empty());
}

Result<imaging::RigCalibration> nominal(const std::string& usb_id, const std::string& options, std::string& source) {
  Device device;
  device.depth.path = "/dev/video0";
  device.depth.usb_id = usb_id;
  return calibration_of(*parse_v4l2_address(*parse_camera_address("v4l2:" + options)), device, source);
}

TEST(V4l2Models, TheCalibrationIsThatOfTheShapesThatAreWanted) {
  struct Case {
    const char *options, *source;
    imaging::ImageSize colour, depth;
    double colour_focal_px, depth_focal_px;
  };
  const Case cases[] = {{"", "nominal for realsense-d435", {640, 480}, {640, 480}, 615, 383},
                        {"?size=320x240", "nominal for realsense-d435", {640, 480}, {640, 480}, 615, 383},
                        {"?size=848x480", "nominal for realsense-d435-848x480", {848, 480}, {848, 480}, 615, 423},
                        {"?size=640x360", "nominal for realsense-d435-1280x720", {1280, 720}, {1280, 720}, 922.5, 638},
                        {"?size=1280x720&depth_size=848x480",
                         "nominal for realsense-d435-1280x720, depth's for realsense-d435-848x480",
                         {1280, 720},
                         {848, 480},
                         922.5,
                         423}};
  for (const Case& c : cases) {
    std::string source;
    const auto rig = nominal("8086:0b07", c.options, source);
    ASSERT_TRUE(rig.ok()) << rig.error().text();
    EXPECT_EQ(source, c.source);
    EXPECT_EQ(imaging::size_of(rig->colour), c.colour) << c.options;
    EXPECT_EQ(imaging::size_of(*rig->depth), c.depth) << c.options;
    EXPECT_EQ(rig->colour.fx, c.colour_focal_px) << c.options;
    EXPECT_EQ(rig->depth->fx, c.depth_focal_px) << c.options;
  }
}

// One lens sees through all sizes: its angles are the same to a per cent, as far as the sizes are scaled pictures.
TEST(V4l2Models, TheSizesOfOneModelAgree) {
  for (const char* id : {"8086:0b07", "8086:0b3a", "8086:0ad3", "8086:0b5c"}) {
    std::string source;
    const auto vga = nominal(id, "", source), hd = nominal(id, "?size=1280x720", source),
               wide = nominal(id, "?size=848x480", source);
    ASSERT_TRUE(vga.ok() && hd.ok() && wide.ok()) << id;
    EXPECT_NEAR(wide->depth->fx / hd->depth->fx, 848 / 1280.0, 0.005) << id;
    EXPECT_EQ(hd->pose.translation_m, vga->pose.translation_m) << id;
    EXPECT_EQ(wide->pose.translation_m, vga->pose.translation_m) << id;
    EXPECT_NEAR(hd->noise.growth_per_m * hd->depth->fx, vga->noise.growth_per_m * vga->depth->fx, 0.05) << id;
    EXPECT_NEAR(wide->noise.growth_per_m * wide->depth->fx, vga->noise.growth_per_m * vga->depth->fx, 0.05) << id;
  }
}

TEST(V4l2Models, AShapeThatIsNotKnownIsAnErrorThatNamesThoseThatAre) {
  std::string source;
  EXPECT_THAT(nominal("8086:0b07", "?size=800x640", source).error().text(),
              HasSubstr("no nominal calibration for colour images of 800x640; there are those of 640x480 848x480 "
                        "1280x720 and of their shapes"));
  EXPECT_THAT(nominal("2bc5:0660", "?depth_size=1280x720", source).error().text(),
              HasSubstr("orbbec-astra2: no nominal calibration for depth images of 1280x720"));
  EXPECT_TRUE(nominal("2bc5:0660", "?size=1600x1200&depth_size=800x600", source).ok());
}

TEST(V4l2Address, ReadsItsOptions) {
  const auto address = parse_camera_address("v4l2:/dev/video3?color=/dev/video5&size=848x480&fps=60&calibration=c.txt");
  const auto parsed = parse_v4l2_address(*address);
  ASSERT_TRUE(parsed.ok()) << parsed.error().text();
  EXPECT_EQ(parsed->depth_path, "/dev/video3");
  EXPECT_EQ(parsed->colour_path, "/dev/video5");
  EXPECT_EQ(*parsed->size, (imaging::ImageSize{848, 480}));
  EXPECT_FALSE(parsed->depth_size.has_value());
  EXPECT_EQ(parsed->fps, 60);
  EXPECT_EQ(parsed->calibration_file, "c.txt");
  EXPECT_FALSE(parsed->as_it_comes);
  EXPECT_TRUE(parse_v4l2_address(*parse_camera_address("v4l2:?registration=none"))->as_it_comes);
}

TEST(V4l2Address, ErrorsSayWhatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {"v4l2:video0", "expected v4l2: or"},
      {"v4l2:?fps=ten", "fps=ten: expected a whole number"},
      {"v4l2:?size=8x8", "size=8x8"},
      {"v4l2:?depth_size=640", "depth_size=640: expected WIDTHxHEIGHT"},
      {"v4l2:?size=640x480x3", "size=640x480x3"},
      {"v4l2:?registration=device", "registration=device: expected ours or none"},
      {"v4l2:?color=", "color names nothing"},
      {"v4l2:?colour=/dev/video1", "unknown option 'colour'"}};
  for (const auto& [text, expected] : cases) {
    const auto parsed = parse_v4l2_address(*parse_camera_address(text));
    ASSERT_FALSE(parsed.ok()) << text;
    EXPECT_THAT(parsed.error().text(), HasSubstr(expected));
  }
}

}  // namespace
}  // namespace onemap::hal::v4l2
