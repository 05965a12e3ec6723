#include "mapping/records/link.hpp"

#include <utility>

#include "records/field_reader.hpp"

namespace onemap::mapping {

namespace {

constexpr std::size_t kPairBytes = 12 + kPoseBytes;

void put_pair(ByteWriter& out, const LinkPair& pair) {
  out.put(pair.keyframe_a);
  out.put(pair.keyframe_b);
  out.put(pair.inliers);
  put(out, pair.T_a_b);
}

LinkPair read_pair(FieldReader& in) {
  LinkPair out;
  out.keyframe_a = in.get<std::uint32_t>("pairs.keyframe_a");
  out.keyframe_b = in.get<std::uint32_t>("pairs.keyframe_b");
  out.inliers = in.get<std::uint32_t>("pairs.inliers");
  in.require(out.inliers > 0 && out.inliers <= kMaxInliersOfPair, "pairs.inliers", "not from 1 to 1000");
  out.T_a_b = in.pose("pairs.T_a_b");
  return out;
}

void read_pairs(FieldReader& in, LinkRecord& out) {
  out.pairs.resize(in.count<std::uint16_t>(kMaxLinkPairs, kPairBytes, "pairs"));
  in.require(out.reason == LinkReason::accepted || out.pairs.empty(), "pairs", "of a link that is refused");
  const auto ends = [](const LinkPair& pair) { return std::pair(pair.keyframe_a, pair.keyframe_b); };
  for (std::size_t i = 0; i < out.pairs.size(); ++i) {
    out.pairs[i] = read_pair(in);
    in.require(i == 0 || ends(out.pairs[i - 1]) < ends(out.pairs[i]), "pairs", "not sorted");
  }
}

}  // namespace

Status check_own_loops(const LinkRecord& record) {
  if (record.T_a_b != QuantizedPose{}) return Error{"link record, T_a_b", "of one life, and not the identity"};
  for (const LinkPair& pair : record.pairs)
    if (pair.keyframe_a >= pair.keyframe_b) return Error{"link record, pairs", "not of two keyframes"};
  return success();
}

std::vector<std::uint8_t> encode(const LinkRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  put(out, record.a);
  put(out, record.b);
  out.put(record.incarnation_other);
  out.put(record.keyframes_a);
  out.put(record.keyframes_b);
  out.put(record.keyframe_a);
  out.put(record.keyframe_b);
  out.put(static_cast<std::uint8_t>(record.reason));
  out.put(record.measured);
  out.put(record.supporting_pairs);
  out.put(record.inliers);
  out.put(record.ratio_e4);
  out.put(record.error_um);
  put(out, record.T_a_b);
  out.put(static_cast<std::uint16_t>(record.pairs.size()));
  for (const LinkPair& pair : record.pairs) put_pair(out, pair);
  return body;
}

Result<LinkRecord> decode_link(std::span<const std::uint8_t> body) {
  FieldReader in("link", body);
  LinkRecord out;
  out.a = in.robot("a");
  out.b = in.robot("b");
  in.require(out.a <= out.b, "b", "before a");
  out.incarnation_other = in.get<std::uint64_t>("incarnation_other");
  out.keyframes_a = in.get<std::uint32_t>("keyframes_a");
  out.keyframes_b = in.get<std::uint32_t>("keyframes_b");
  out.keyframe_a = in.get<std::uint32_t>("keyframe_a");
  out.keyframe_b = in.get<std::uint32_t>("keyframe_b");
  const auto reason = in.get<std::uint8_t>("reason");
  in.require(reason <= static_cast<std::uint8_t>(kLastLinkReason), "reason", "unknown");
  out.reason = static_cast<LinkReason>(reason);
  out.measured = in.get<std::uint32_t>("measured");
  in.require(out.reason != LinkReason::accepted || out.measured == 0, "measured", "of a link that is accepted");
  out.supporting_pairs = in.get<std::uint32_t>("supporting_pairs");
  out.inliers = in.get<std::uint32_t>("inliers");
  out.ratio_e4 = in.get<std::uint32_t>("ratio_e4");
  in.require(out.ratio_e4 <= 10000, "ratio_e4", "more than 10000");
  out.error_um = in.get<std::int32_t>("error_um");
  in.require(out.error_um >= 0, "error_um", "negative");
  const std::uint64_t most = std::uint64_t{kMaxInliersOfPair} * out.supporting_pairs;
  in.require(out.supporting_pairs <= kMaxSupportingPairs, "supporting_pairs", "more than are looked at");
  in.require(out.reason != LinkReason::accepted || out.inliers <= most, "inliers", "more than the pairs have features");
  out.T_a_b = in.pose("T_a_b");
  read_pairs(in, out);
  return in.finish(std::move(out));
}

}  // namespace onemap::mapping
