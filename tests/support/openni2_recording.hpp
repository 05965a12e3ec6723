#pragma once
// What OpenNI2's own recorder writes of a device of the test driver.
#include <OpenNI.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>

#include "support/openni2_devices.hpp"

namespace onemap::test {

// As any program records: the device's own settings, mirrored; a step, then both images.
// The device was plugged with `steps 1`. When the machine is busy the recorder leaves images out.
inline void record(OpenNi2Devices& devices, const std::string& name, const std::string& file, int frames) {
  ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
  {
    openni::Device device;
    openni::VideoStream depth, colour;
    openni::Recorder recorder;
    ASSERT_EQ(device.open(("room://" + name).c_str()), openni::STATUS_OK) << openni::OpenNI::getExtendedError();
    ASSERT_EQ(depth.create(device, openni::SENSOR_DEPTH), openni::STATUS_OK);
    ASSERT_EQ(colour.create(device, openni::SENSOR_COLOR), openni::STATUS_OK);
    for (openni::VideoStream* stream : {&depth, &colour}) {
      const auto& modes = stream->getSensorInfo().getSupportedVideoModes();
      ASSERT_EQ(stream->setVideoMode(modes[2]), openni::STATUS_OK);
    }
    ASSERT_EQ(device.setImageRegistrationMode(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR), openni::STATUS_OK);
    ASSERT_EQ(recorder.create(file.c_str()), openni::STATUS_OK);
    ASSERT_EQ(recorder.attach(depth), openni::STATUS_OK);
    ASSERT_EQ(recorder.attach(colour, false), openni::STATUS_OK);
    ASSERT_EQ(recorder.start(), openni::STATUS_OK);
    ASSERT_EQ(depth.start(), openni::STATUS_OK);
    ASSERT_EQ(colour.start(), openni::STATUS_OK);
    std::array<openni::VideoStream*, 2> streams{&depth, &colour};
    for (int i = 0; i < frames; ++i) {
      devices.step(name);
      for (int image = 0; image < 2; ++image) {
        int ready = 0;
        ASSERT_EQ(openni::OpenNI::waitForAnyStream(streams.data(), 2, &ready, 20000), openni::STATUS_OK);
        openni::VideoFrameRef frame;
        ASSERT_EQ(streams[static_cast<std::size_t>(ready)]->readFrame(&frame), openni::STATUS_OK);
      }
    }
    recorder.stop();
    recorder.destroy();
    depth.destroy();
    colour.destroy();
    device.close();
  }
  openni::OpenNI::shutdown();
}

// How many images of each stream a recording holds, depth and colour, by the library's own player.
inline std::array<int, 2> images_in(const std::string& file) {
  std::array<int, 2> images{};
  EXPECT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
  {
    openni::Device device;
    openni::VideoStream depth, colour;
    if (device.open(file.c_str()) == openni::STATUS_OK &&
        depth.create(device, openni::SENSOR_DEPTH) == openni::STATUS_OK &&
        colour.create(device, openni::SENSOR_COLOR) == openni::STATUS_OK)
      images = {device.getPlaybackControl()->getNumberOfFrames(depth),
                device.getPlaybackControl()->getNumberOfFrames(colour)};
    depth.destroy();
    colour.destroy();
    device.close();
  }
  // The player's thread was cancelled and not waited for; the library is unloaded now.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  openni::OpenNI::shutdown();
  return images;
}

}  // namespace onemap::test
