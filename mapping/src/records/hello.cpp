#include "mapping/records/hello.hpp"

#include <algorithm>

#include "mapping/records/solution.hpp"
#include "records/field_reader.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kMaxCameraText = 200;

bool printable(std::string_view text) {
  return std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; });
}

std::string text_of(std::span<const std::uint8_t> bytes) { return {bytes.begin(), bytes.end()}; }

void put_text(ByteWriter& out, const std::string& text) {
  out.put(static_cast<std::uint8_t>(text.size()));
  for (const char c : text) out.put(static_cast<std::uint8_t>(c));
}

}  // namespace

std::vector<std::uint8_t> encode(const HelloRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  put_text(out, record.name);
  put_text(out, record.camera);
  out.put(record.repeats);
  out.put(record.map_blocks);
  return body;
}

Result<HelloRecord> decode_hello(std::span<const std::uint8_t> body) {
  FieldReader in("hello", body);
  HelloRecord out;
  out.name = text_of(in.bytes(in.get<std::uint8_t>("name"), "name"));
  in.require(RobotId::valid_name(out.name), "name", "not 1 to 16 of A-Z a-z 0-9 _ . -");
  const std::size_t size = in.get<std::uint8_t>("camera");
  in.require(size <= kMaxCameraText, "camera", "longer than 200");
  out.camera = text_of(in.bytes(size, "camera"));
  in.require(printable(out.camera), "camera", "control characters");
  out.repeats = in.get<std::uint64_t>("repeats");
  out.map_blocks = in.get<std::uint32_t>("map blocks");
  in.require(out.map_blocks <= MapParameters::kMostBlocks, "map blocks", "more than 2^24");
  return in.finish(std::move(out));
}

}  // namespace onemap::mapping
