#include "mapping/records/finished.hpp"

#include "records/field_reader.hpp"

namespace onemap::mapping {

std::vector<std::uint8_t> encode(const FinishedRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  for (const std::uint32_t n : {record.frames, record.tracked, record.keyframes, record.submaps}) out.put(n);
  return body;
}

Result<FinishedRecord> decode_finished(std::span<const std::uint8_t> body) {
  FieldReader in("finished", body);
  FinishedRecord out;
  out.frames = in.get<std::uint32_t>("frames");
  out.tracked = in.get<std::uint32_t>("tracked");
  out.keyframes = in.get<std::uint32_t>("keyframes");
  out.submaps = in.get<std::uint32_t>("submaps");
  in.require(out.tracked <= out.frames, "tracked", "more than frames");
  return in.finish(out);
}

}  // namespace onemap::mapping
