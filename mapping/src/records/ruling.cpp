#include "mapping/records/ruling.hpp"

#include "records/field_reader.hpp"

namespace onemap::mapping {

std::vector<std::uint8_t> encode(const RulingRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  put(out, record.a);
  put(out, record.b);
  out.put(static_cast<std::uint8_t>(record.apart ? 1 : 0));
  out.put(record.turn);
  return body;
}

Result<RulingRecord> decode_ruling(std::span<const std::uint8_t> body) {
  FieldReader in("ruling", body);
  RulingRecord out;
  out.a = in.chain("a");
  out.b = in.chain("b");
  in.require(!(out.b < out.a), "b", "before a");
  const auto apart = in.get<std::uint8_t>("apart");
  in.require(apart <= 1, "apart", "neither 0 nor 1");
  out.apart = apart == 1;
  out.turn = in.get<std::uint32_t>("turn");
  in.require(out.turn >= 1 && out.turn <= kMostTurns, "turn", "not from 1 to 2^31");
  return in.finish(out);
}

}  // namespace onemap::mapping
