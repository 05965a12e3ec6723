#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "hal/frame.hpp"
#include "mapping/geometry.hpp"

namespace onemap::daemon {

// Messages of Foxglove's well-known schemas as JSON, for McapWriter: what Foxglove's and others' tools draw without
// being told anything. Frames as in ROS REP 105: map, odom, and camera (optical: x right, y down, z forward). Pure.

// The JSON schema of foxglove.NAME, for NAME of the functions below.
std::string foxglove_schema(std::string_view name);

std::string base64(std::span<const std::uint8_t> bytes);

// FrameTransform: T_parent_child.
std::string frame_transform(FrameTime time, std::string_view parent, std::string_view child, const mapping::Pose& T);
// PoseInFrame: where the camera is in this frame.
std::string pose_in_frame(FrameTime time, std::string_view frame, const mapping::Pose& T);
// CompressedImage in the camera's frame. format: "jpeg" or "png".
std::string compressed_image(FrameTime time, std::string_view format, std::span<const std::uint8_t> file);
// PointCloud in the camera's frame: every step-th reading of every step-th row, with its colour. A lens's distortion is
// not taken out.
std::string point_cloud(const hal::FrameView& frame, int step);

}  // namespace onemap::daemon
