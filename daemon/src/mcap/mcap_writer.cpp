#include "daemon/mcap/mcap_writer.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <system_error>
#include <utility>

#include "hal/base/bytes.hpp"

namespace onemap::daemon {

namespace {

enum class Op : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  statistics = 0x0b,
  summary_offset = 0x0e,
  data_end = 0x0f,
};
using Bytes = std::vector<std::uint8_t>;
constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
constexpr int kCompression = 1;

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// Not inlined: GCC 12 sees several of these in a row write out of bounds, where they do not.
template <class T>
[[gnu::noinline]] void put_number(ByteWriter& out, T value) {
  out.put(value);
}

void put_string(ByteWriter& out, std::string_view text) {
  put_number(out, static_cast<std::uint32_t>(text.size()));
  out.bytes(bytes_of(text));
}

void put_record(Bytes& out, Op op, std::span<const std::uint8_t> content) {
  ByteWriter writer(out);
  put_number(writer, static_cast<std::uint8_t>(op));
  put_number(writer, static_cast<std::uint64_t>(content.size()));
  writer.bytes(content);
}

constexpr std::array<std::uint32_t, 256> kCrcTable = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int k = 0; k < 8; ++k) c = (c & 1) != 0 ? 0xedb88320u ^ (c >> 1) : c >> 1;
    table[i] = c;
  }
  return table;
}();

Bytes schema_record(std::uint16_t id, const std::string& name, const std::string& text) {
  Bytes content, record;
  ByteWriter out(content);
  put_number(out, id);
  put_string(out, name);
  put_string(out, "jsonschema");
  put_string(out, text);
  put_record(record, Op::schema, content);
  return record;
}

Bytes channel_record(std::uint16_t id, std::uint16_t schema, const std::string& topic) {
  Bytes content, record;
  ByteWriter out(content);
  put_number(out, id);
  put_number(out, schema);
  put_string(out, topic);
  put_string(out, "json");
  put_number(out, std::uint32_t{0});  // no metadata
  put_record(record, Op::channel, content);
  return record;
}

std::uint64_t time_of(FrameTime time) { return static_cast<std::uint64_t>(time.time_since_epoch().count()); }

}  // namespace

std::uint32_t crc32(std::uint32_t before, std::span<const std::uint8_t> bytes) {
  std::uint32_t c = ~before;
  for (const std::uint8_t b : bytes) c = kCrcTable[(c ^ b) & 0xff] ^ (c >> 8);
  return ~c;
}

void McapWriter::Span::add(std::uint64_t time) {
  first = any ? std::min(first, time) : time;
  last = any ? std::max(last, time) : time;
  any = true;
}

Result<McapWriter> McapWriter::create(const std::string& path, const std::string& library) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0) return Error{path, "cannot write: " + std::generic_category().message(errno)};
  McapWriter writer(path, file);
  Bytes head(kMagic.begin(), kMagic.end()), content;
  ByteWriter out(content);
  put_string(out, "");  // no profile
  put_string(out, library);
  put_record(head, Op::header, content);
  if (auto written = writer.put(head); !written) return written.error();
  return Result<McapWriter>(std::move(writer));
}

McapWriter::McapWriter(McapWriter&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      offset_(other.offset_),
      crc_(other.crc_),
      channels_(std::move(other.channels_)),
      chunk_(std::move(other.chunk_)),
      chunk_times_(other.chunk_times_),
      times_(other.times_),
      chunk_indices_(std::move(other.chunk_indices_)),
      chunks_(other.chunks_),
      messages_(other.messages_) {}

McapWriter::~McapWriter() {
  if (file_ >= 0) ::close(file_);
}

Status McapWriter::put(std::span<const std::uint8_t> bytes) {
  crc_ = crc32(crc_, bytes);
  offset_ += bytes.size();
  while (!bytes.empty()) {
    const ssize_t n = ::write(file_, bytes.data(), bytes.size());
    if (n < 0 && errno != EINTR) return Error{path_, "cannot write: " + std::generic_category().message(errno)};
    if (n > 0) bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return success();
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const std::string& schema_name,
                                      const std::string& schema_text) {
  assert(channels_.size() < 65535);
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);  // of the channel, and of its own schema
  Channel& channel = channels_[id];
  channel.schema = schema_record(id, schema_name, schema_text);
  channel.channel = channel_record(id, id, topic);
  return id;
}

Status McapWriter::write(std::uint16_t id, FrameTime at, std::string_view json) {
  assert(channels_.contains(id));
  Channel& channel = channels_[id];
  ByteWriter chunk(chunk_);
  if (channel.messages == 0) {  // a channel is said before its first message
    chunk.bytes(channel.schema);
    chunk.bytes(channel.channel);
  }
  const std::uint64_t time = time_of(at);
  channel.index.push_back({time, chunk_.size()});
  put_number(chunk, static_cast<std::uint8_t>(Op::message));
  put_number(chunk, static_cast<std::uint64_t>(2 + 4 + 8 + 8 + json.size()));
  put_number(chunk, id);
  put_number(chunk, channel.messages++);
  put_number(chunk, time);
  put_number(chunk, time);
  chunk.bytes(bytes_of(json));
  chunk_times_.add(time);
  times_.add(time);
  ++messages_;
  return chunk_.size() < kChunkBytes ? success() : flush();
}

// A message index of each channel of the chunk; `offsets`: a map from channel to where it is in the file.
Status McapWriter::put_indices(std::vector<std::uint8_t>& offsets) {
  ByteWriter map(offsets);
  for (auto& [id, channel] : channels_) {
    if (channel.index.empty()) continue;
    Bytes content, record;
    ByteWriter out(content);
    put_number(out, id);
    put_number(out, static_cast<std::uint32_t>(16 * channel.index.size()));
    for (const Entry& entry : channel.index) {
      put_number(out, entry.time);
      put_number(out, entry.offset);
    }
    channel.index.clear();
    put_number(map, id);
    put_number(map, offset_);
    put_record(record, Op::message_index, content);
    if (auto written = put(record); !written) return written;
  }
  return success();
}

Status McapWriter::flush() {
  if (chunk_.empty()) return success();
  packed_.resize(ZSTD_compressBound(chunk_.size()));
  const std::size_t size = ZSTD_compress(packed_.data(), packed_.size(), chunk_.data(), chunk_.size(), kCompression);
  if (ZSTD_isError(size) != 0) return Error{path_, std::string("cannot compress: ") + ZSTD_getErrorName(size)};
  Bytes content, record, offsets, index;
  ByteWriter out(content);
  put_number(out, chunk_times_.first);
  put_number(out, chunk_times_.last);
  put_number(out, static_cast<std::uint64_t>(chunk_.size()));
  put_number(out, crc32(0, chunk_));
  put_string(out, "zstd");
  put_number(out, static_cast<std::uint64_t>(size));
  out.bytes({packed_.data(), size});
  put_record(record, Op::chunk, content);
  const std::uint64_t start = offset_;
  if (auto written = put(record); !written) return written;
  const std::uint64_t indices = offset_;
  if (auto written = put_indices(offsets); !written) return written;
  ByteWriter at(index);
  put_number(at, chunk_times_.first);
  put_number(at, chunk_times_.last);
  put_number(at, start);
  put_number(at, static_cast<std::uint64_t>(record.size()));
  put_number(at, static_cast<std::uint32_t>(offsets.size()));
  at.bytes(offsets);
  put_number(at, offset_ - indices);
  put_string(at, "zstd");
  put_number(at, static_cast<std::uint64_t>(size));
  put_number(at, static_cast<std::uint64_t>(chunk_.size()));
  put_record(chunk_indices_, Op::chunk_index, index);
  ++chunks_;
  chunk_.clear();
  chunk_times_ = {};
  return success();
}

std::vector<std::uint8_t> McapWriter::statistics() const {
  Bytes content, counts, record;
  ByteWriter out(content), map(counts);
  std::uint32_t used = 0;
  for (const auto& [id, channel] : channels_) {
    if (channel.messages == 0) continue;  // it was never said
    ++used;
    put_number(map, id);
    put_number(map, static_cast<std::uint64_t>(channel.messages));
  }
  put_number(out, messages_);
  put_number(out, static_cast<std::uint16_t>(used));
  put_number(out, used);
  put_number(out, std::uint32_t{0});  // attachments
  put_number(out, std::uint32_t{0});  // metadata
  put_number(out, chunks_);
  put_number(out, times_.first);
  put_number(out, times_.last);
  put_number(out, static_cast<std::uint32_t>(counts.size()));
  out.bytes(counts);
  put_record(record, Op::statistics, content);
  return record;
}

Status McapWriter::put_summary() {
  Bytes schemas, channels;
  for (const auto& [id, channel] : channels_) {
    if (channel.messages == 0) continue;
    schemas.insert(schemas.end(), channel.schema.begin(), channel.schema.end());
    channels.insert(channels.end(), channel.channel.begin(), channel.channel.end());
  }
  const std::uint64_t summary = offset_;
  crc_ = 0;  // the footer's is of the summary
  Bytes where;
  const std::pair<Op, Bytes> groups[] = {{Op::schema, std::move(schemas)},
                                         {Op::channel, std::move(channels)},
                                         {Op::chunk_index, chunk_indices_},
                                         {Op::statistics, statistics()}};
  for (const auto& [op, group] : groups) {
    if (group.empty()) continue;
    Bytes content;
    ByteWriter out(content);
    put_number(out, static_cast<std::uint8_t>(op));
    put_number(out, offset_);
    put_number(out, static_cast<std::uint64_t>(group.size()));
    put_record(where, Op::summary_offset, content);
    if (auto written = put(group); !written) return written;
  }
  const std::uint64_t offsets = offset_;
  if (auto written = put(where); !written) return written;
  Bytes footer;
  ByteWriter out(footer);
  put_number(out, static_cast<std::uint8_t>(Op::footer));
  put_number(out, std::uint64_t{8 + 8 + 4});
  put_number(out, summary);
  put_number(out, offsets);
  put_number(out, crc32(crc_, footer));
  out.bytes(kMagic);
  return put(footer);
}

Status McapWriter::finish() {
  if (auto flushed = flush(); !flushed) return flushed;
  Bytes content, record;
  ByteWriter out(content);
  put_number(out, crc_);
  put_record(record, Op::data_end, content);
  if (auto written = put(record); !written) return written;
  if (auto written = put_summary(); !written) return written;
  if (::close(std::exchange(file_, -1)) != 0)
    return Error{path_, "cannot close: " + std::generic_category().message(errno)};
  return success();
}

}  // namespace onemap::daemon
