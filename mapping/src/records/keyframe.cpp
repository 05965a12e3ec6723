// The keyframe body: index, time, pose, kind of descriptor, number of features; of each feature 40 bits of its place
// and sign (u, v, inverse depth of 13 bits each, lowest first, then 1 for a Laplacian of 1) and 32 bytes of bits; then
// the depth grid (depth_grid_codec.hpp).
#include "mapping/records/keyframe.hpp"

#include <cmath>

#include "records/depth_grid_codec.hpp"
#include "records/field_reader.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kMaxFeatures = 1000;
constexpr std::size_t kPlaceBytes = 5, kFeatureBytes = kPlaceBytes + sizeof(DescriptorBits);
constexpr double kMiddle = 1 << (FeaturePlace::kBits - 1);

double along(std::int32_t k) { return k / 1024.0; }

// Of one axis: the pixel from the middle of the grid.
double encoded(double ray, double f, double c, int side_px) {
  return std::round((ray * f + c - side_px / 2.0) * FeaturePlace::kStepsPerPixel) + kMiddle;
}
double decoded(std::uint16_t at, double f, double c, int side_px) {
  return ((at - kMiddle) / FeaturePlace::kStepsPerPixel + side_px / 2.0 - c) / f;
}

void put(ByteWriter& out, const KeyframeFeature& feature) {
  const FeaturePlace& p = feature.place;
  constexpr int kBits = FeaturePlace::kBits;
  std::uint64_t place = p.u | (std::uint64_t{p.v} << kBits) | (std::uint64_t{p.inverse_depth} << (2 * kBits)) |
                        (std::uint64_t{feature.laplacian > 0} << (3 * kBits));
  for (std::size_t i = 0; i < kPlaceBytes; ++i, place >>= 8) out.put(static_cast<std::uint8_t>(place & 0xFF));
  for (const std::uint64_t word : feature.bits) out.put(word);
}

KeyframeFeature read_feature(FieldReader& in, DescriptorKind kind) {
  std::uint64_t place = 0;
  for (std::size_t i = 0; i < kPlaceBytes; ++i)
    place |= std::uint64_t{in.get<std::uint8_t>("features.place")} << (8 * i);
  const auto part = [place](int n) {
    return static_cast<std::uint16_t>((place >> (n * FeaturePlace::kBits)) & FeaturePlace::kMost);
  };
  KeyframeFeature out;
  out.place = {part(0), part(1), part(2)};
  in.require(out.place.inverse_depth > 0, "features.place", "not in front of the camera");
  const bool bright = part(3) != 0;
  in.require(kind == DescriptorKind::surf_bits || !bright, "features.place", "a Laplacian, which ORB has not");
  out.laplacian = static_cast<std::int8_t>(bright ? 1 : kind == DescriptorKind::surf_bits ? -1 : 0);
  for (std::uint64_t& word : out.bits) word = in.get<std::uint64_t>("features.bits");
  return out;
}

}  // namespace

std::optional<FeaturePlace> to_place(const Vector3d& p, const DepthGrid& grid) {
  if (!(p.z() > 0)) return std::nullopt;
  const auto& k = grid.fx_fy_cx_cy;
  const double u = encoded(p.x() / p.z(), along(k[0]), along(k[2]), grid.width);
  const double v = encoded(p.y() / p.z(), along(k[1]), along(k[3]), grid.height);
  const double inverse_depth = std::round(FeaturePlace::kStepsPerInverseMetre / p.z());
  const auto fits = [](double x, double least) { return x >= least && x <= FeaturePlace::kMost; };
  if (!fits(u, 0) || !fits(v, 0) || !fits(inverse_depth, 1)) return std::nullopt;
  return FeaturePlace{static_cast<std::uint16_t>(u), static_cast<std::uint16_t>(v),
                      static_cast<std::uint16_t>(inverse_depth)};
}

Eigen::Vector2d place_ray(const FeaturePlace& place, const DepthGrid& grid) {
  const auto& k = grid.fx_fy_cx_cy;
  return {decoded(place.u, along(k[0]), along(k[2]), grid.width),
          decoded(place.v, along(k[1]), along(k[3]), grid.height)};
}

Vector3d place_point(const FeaturePlace& place, const DepthGrid& grid) {
  const double z = FeaturePlace::kStepsPerInverseMetre / place.inverse_depth;
  const Eigen::Vector2d ray = place_ray(place, grid);
  return {ray.x() * z, ray.y() * z, z};
}

std::vector<std::uint8_t> encode(const KeyframeRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  out.put(record.index);
  put(out, record.time);
  put(out, record.T_robot_keyframe);
  out.put(record.anchor);
  out.put(static_cast<std::uint8_t>(record.descriptor_kind));
  out.put(static_cast<std::uint16_t>(record.features.size()));
  for (const KeyframeFeature& feature : record.features) put(out, feature);
  put(out, record.grid);
  body.shrink_to_fit();  // it is kept for the team's whole life
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
  const auto kind = static_cast<DescriptorKind>(in.get<std::uint8_t>("descriptor_kind"));
  in.require(kind == DescriptorKind::orb || kind == DescriptorKind::surf_bits, "descriptor_kind", "unknown");
  if (in.ok()) out.descriptor_kind = kind;
  const std::size_t n = in.count<std::uint16_t>(kMaxFeatures, kFeatureBytes, "features");
  out.features.reserve(n);
  for (std::size_t i = 0; i < n; ++i) out.features.push_back(read_feature(in, out.descriptor_kind));
  out.grid = read_grid_head(in);
  read_grid_depths(in, out.grid);
  return in.finish(std::move(out));
}

}  // namespace onemap::mapping
