#include "render/png_writer.hpp"

#include <gtest/gtest.h>

#include "picture.hpp"
#include "temp_folder.hpp"

namespace onemap::render {
namespace {

Image pattern(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.set(x, y,
                {static_cast<std::uint8_t>(x * 7), static_cast<std::uint8_t>(y * 5), static_cast<std::uint8_t>(x * y)});
  return image;
}

TEST(Png, is_read_back_by_libpng_pixel_for_pixel) {
  const test::TempFolder folder;
  for (const auto& [w, h] : {std::pair{1, 1}, {3, 2}, {641, 37}}) {
    const Image image = pattern(w, h);
    ASSERT_TRUE(write_png(folder / "a.png", image).ok());
    const Image back = test::read_png(folder / "a.png");
    EXPECT_EQ(back.width, w);
    EXPECT_EQ(back.height, h);
    EXPECT_EQ(back.rgb, image.rgb);
  }
}

TEST(Png, the_same_image_gives_the_same_bytes) {
  EXPECT_EQ(*encode_png(pattern(100, 50)), *encode_png(pattern(100, 50)));
}

TEST(Png, errors_name_the_path) {
  const auto empty = write_png("/tmp/never.png", Image());
  ASSERT_FALSE(empty.ok());
  EXPECT_NE(empty.error().text().find("/tmp/never.png"), std::string::npos);
  Image torn = pattern(4, 4);
  torn.rgb.pop_back();
  EXPECT_FALSE(encode_png(torn).ok());
  const auto missing = write_png("/no/such/folder/a.png", pattern(4, 4));
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().text(),
            "/no/such/folder/a.png: cannot write: folder '/no/such/folder': No such file or directory");
}

}  // namespace
}  // namespace onemap::render
