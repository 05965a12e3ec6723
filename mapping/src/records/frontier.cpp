#include "mapping/records/frontier.hpp"

#include "records/field_reader.hpp"

namespace onemap::mapping {

namespace {
constexpr std::size_t kMaxChains = 1024, kChainBytes = 16 + 8 + 4 + 4;
}

std::vector<std::uint8_t> encode(const FrontierRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  out.put(record.solution);
  out.put(static_cast<std::uint16_t>(record.chains.size()));
  for (const ChainExtent& extent : record.chains) {
    put(out, extent.chain);
    out.put(extent.keyframes);
    out.put(extent.submaps);
  }
  return body;
}

Result<FrontierRecord> decode_frontier(std::span<const std::uint8_t> body) {
  FieldReader in("frontier", body);
  FrontierRecord out;
  out.solution = in.get<std::uint64_t>("solution");
  out.chains.resize(in.count<std::uint16_t>(kMaxChains, kChainBytes, "chains"));
  for (std::size_t i = 0; i < out.chains.size(); ++i) {
    out.chains[i].chain = in.chain("chains.chain");
    out.chains[i].keyframes = in.get<std::uint32_t>("chains.keyframes");
    out.chains[i].submaps = in.get<std::uint32_t>("chains.submaps");
    in.require(i == 0 || out.chains[i - 1].chain < out.chains[i].chain, "chains", "not sorted");
  }
  return in.finish(std::move(out));
}

}  // namespace onemap::mapping
