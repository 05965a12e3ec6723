#ifdef ONEMAP_FAKENECT_DIR
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "hal/backends/libusb/ticks.hpp"
#include "image_ring.hpp"
#include "usb.hpp"

// The parts of the Kinect backend that need no Kinect.
namespace onemap::hal::libusb {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(KinectTicks, GoOnWhereTheCounterStartsAgain) {
  Ticks ticks;
  EXPECT_EQ(ticks.at(0xffff'fff0), Duration(0xffff'fff0ll * 50 / 3));
  EXPECT_EQ(ticks.at(0x10), Duration(0x1'0000'0010ll * 50 / 3));
  EXPECT_EQ(ticks.at(0x8), Duration(0x1'0000'0008ll * 50 / 3)) << "the other stream's may be a little earlier";
  Duration last = ticks.at(0x10);
  std::uint32_t counter = 0x10;
  for (int frame = 0; frame < 5000; ++frame) {  // more than two turns
    counter += 2'000'000;
    const Duration now = ticks.at(counter);
    EXPECT_NEAR(static_cast<double>((now - last).count()), 2'000'000 * 50 / 3.0, 1);
    last = now;
  }
}

TEST(KinectRing, GivesImagesInOrderAndTheirMemory) {
  ImageRing ring(4, 8);
  auto* depth = static_cast<std::uint8_t*>(ring.first_slot(Stream::depth));
  auto* colour = static_cast<std::uint8_t*>(ring.first_slot(Stream::colour));
  for (std::uint8_t i = 0; i < 3; ++i) {
    depth[0] = i;
    depth = static_cast<std::uint8_t*>(ring.filled(Stream::depth, 100u + i));
    colour[7] = static_cast<std::uint8_t>(10 + i);
    colour = static_cast<std::uint8_t*>(ring.filled(Stream::colour, 200u + i));
  }
  for (std::uint8_t i = 0; i < 3; ++i) {
    const auto d = ring.take(0ms), c = ring.take(0ms);
    ASSERT_TRUE(d && c);
    EXPECT_EQ(d->stream, Stream::depth);
    EXPECT_EQ(d->ticks, 100u + i);
    EXPECT_EQ(ring.bytes(*d)[0], i);
    EXPECT_EQ(c->number, i);
    EXPECT_EQ(ring.bytes(*c)[7], 10 + i);
    EXPECT_EQ(ring.bytes(*c).size(), 8u);
    ring.give_back(*d);
    ring.give_back(*c);
  }
  EXPECT_FALSE(ring.take(1ms));
}

TEST(KinectRing, TheOldestMakesRoomWhenNobodyTakes) {
  ImageRing ring(1, 1);
  for (std::uint32_t i = 0; i < 20; ++i) ring.filled(Stream::depth, i);
  std::vector<std::uint64_t> numbers;
  while (const auto image = ring.take(0ms)) numbers.push_back(image->number);
  EXPECT_THAT(numbers, testing::ElementsAre(15, 16, 17, 18, 19));
}

TEST(KinectRing, WhenAllIsHeldTheNextImageIsLostAndNothingElse) {
  ImageRing ring(1, 1);
  std::vector<ImageRing::Image> held;
  for (std::uint32_t i = 0; i < 5; ++i) {
    ring.filled(Stream::colour, i);
    held.push_back(*ring.take(0ms));
  }
  void* slot = ring.filled(Stream::colour, 5);
  EXPECT_EQ(ring.filled(Stream::colour, 6), slot);
  EXPECT_FALSE(ring.take(0ms));
  ring.give_back(held[0]);
  ring.filled(Stream::colour, 7);
  EXPECT_EQ(ring.take(0ms)->number, 7u);
}

TEST(KinectRing, ClosingWakesWhoWaits) {
  ImageRing ring(1, 1);
  std::thread closer([&] { ring.close(); });
  EXPECT_FALSE(ring.take(60s));
  closer.join();
}

TEST(KinectUsb, SlowPortsAreToldApart) {
  EXPECT_THAT(speed_problem(LIBUSB_SPEED_FULL), HasSubstr("12 Mbit/s"));
  EXPECT_THAT(speed_problem(LIBUSB_SPEED_LOW), HasSubstr("1.5 Mbit/s"));
  EXPECT_EQ(speed_problem(LIBUSB_SPEED_HIGH), "");
  EXPECT_EQ(speed_problem(LIBUSB_SPEED_UNKNOWN), "");
}

}  // namespace
}  // namespace onemap::hal::libusb
#endif
