#include <algorithm>

#include "mapping/records/keyframe.hpp"
#include "records/field_reader.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kMaxFeatures = 1000;
constexpr int kMaxGridWidth = 160, kMaxGridHeight = 120;

// ORB fills the first 32 of the 64 bytes; the zeros are not sent.
std::size_t descriptor_bytes(DescriptorKind kind) { return kind == DescriptorKind::orb ? 32 : 64; }

KeyframeFeature read_feature(FieldReader& in, DescriptorKind kind) {
  KeyframeFeature out;
  for (auto& c : out.point) c = in.get<std::int16_t>("features.point");
  in.require(out.point[2] > 0, "features.point", "not in front of the camera");
  out.laplacian = in.get<std::int8_t>("features.laplacian");
  const int most = kind == DescriptorKind::surf ? 1 : 0;
  in.require(out.laplacian >= -most && out.laplacian <= most, "features.laplacian", "not -1, 0 or 1");
  const auto bytes = in.bytes(descriptor_bytes(kind), "features.descriptor");
  std::transform(bytes.begin(), bytes.end(), out.descriptor.v.begin(),
                 [](std::uint8_t b) { return static_cast<std::int8_t>(b); });
  return out;
}

DepthGrid read_grid(FieldReader& in) {
  DepthGrid out;
  out.width = in.get<std::uint16_t>("grid.width");
  out.height = in.get<std::uint16_t>("grid.height");
  in.require(out.width <= kMaxGridWidth && out.height <= kMaxGridHeight, "grid.width", "larger than 160 x 120");
  in.require((out.width == 0) == (out.height == 0), "grid.height", "zero on one side only");
  for (auto& k : out.fx_fy_cx_cy) k = in.get<std::int32_t>("grid.fx_fy_cx_cy");
  in.require(out.width == 0 || (out.fx_fy_cx_cy[0] > 0 && out.fx_fy_cx_cy[1] > 0), "grid.fx_fy_cx_cy",
             "focal length not positive");
  const std::size_t cells = static_cast<std::size_t>(out.width) * out.height;
  in.require(2 * cells <= in.remaining(), "grid.depth", "cut short");
  if (!in.ok()) return out;
  out.depth.resize(cells);
  for (auto& z : out.depth) z = in.get<std::uint16_t>("grid.depth");
  return out;
}

}  // namespace

std::vector<std::uint8_t> encode(const KeyframeRecord& record) {
  const std::size_t descriptor = descriptor_bytes(record.descriptor_kind);
  std::vector<std::uint8_t> body;
  body.reserve(64 + record.features.size() * (7 + descriptor) + 2 * record.grid.depth.size());
  ByteWriter out(body);
  out.put(record.index);
  put(out, record.time);
  put(out, record.T_robot_keyframe);
  out.put(record.anchor);
  out.put(static_cast<std::uint8_t>(record.descriptor_kind));
  out.put(static_cast<std::uint16_t>(record.features.size()));
  for (const KeyframeFeature& feature : record.features) {
    for (const std::int16_t c : feature.point) out.put(c);
    out.put(feature.laplacian);
    for (std::size_t i = 0; i < descriptor; ++i) out.put(feature.descriptor.v[i]);
  }
  out.put(record.grid.width);
  out.put(record.grid.height);
  for (const std::int32_t k : record.grid.fx_fy_cx_cy) out.put(k);
  for (const std::uint16_t z : record.grid.depth) out.put(z);
  return body;
}

Result<KeyframeRecord> decode_keyframe(std::span<const std::uint8_t> body) {
  FieldReader in("keyframe", body);
  KeyframeRecord out;
  out.index = in.get<std::uint32_t>("index");
  out.time = in.time("time");
  out.T_robot_keyframe = in.pose("T_robot_keyframe");
  out.anchor = in.get<std::uint32_t>("anchor");
  in.require(out.anchor <= out.index, "anchor", "a later keyframe");
  const auto kind = in.get<std::uint8_t>("descriptor_kind");
  in.require(kind == 1 || kind == 2, "descriptor_kind", "unknown");
  out.descriptor_kind = kind == 2 ? DescriptorKind::orb : DescriptorKind::surf;
  const std::size_t n = in.count<std::uint16_t>(kMaxFeatures, 7 + descriptor_bytes(out.descriptor_kind), "features");
  out.features.reserve(n);
  for (std::size_t i = 0; i < n; ++i) out.features.push_back(read_feature(in, out.descriptor_kind));
  out.grid = read_grid(in);
  return in.finish(std::move(out));
}

}  // namespace onemap::mapping
