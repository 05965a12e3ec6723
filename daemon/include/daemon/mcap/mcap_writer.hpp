#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

// CRC-32 as in zlib, PNG and MCAP, over what came before and these bytes.
std::uint32_t crc32(std::uint32_t before, std::span<const std::uint8_t> bytes);

// Writes an MCAP file (mcap.dev, version 0): JSON messages in zstd-compressed chunks with message indices, a summary
// with statistics and chunk indices, and all checksums. A chunk is on its way to the disk when it is full; a file that
// was not finished lacks its summary and its last chunk, and `mcap recover` reads the rest. Used by one thread.
class McapWriter {
 public:
  // A file that is there is refused. library: who writes it, for people.
  static Result<McapWriter> create(const std::string& path, const std::string& library);
  McapWriter(McapWriter&& other) noexcept;
  McapWriter& operator=(McapWriter&&) = delete;
  ~McapWriter();

  // The number of a channel of JSON messages; schema_text is its JSON schema. At most 65535.
  std::uint16_t add_channel(const std::string& topic, const std::string& schema_name, const std::string& schema_text);
  Status write(std::uint16_t channel, FrameTime time, std::string_view json);
  Status finish();                                 // nothing may follow
  std::uint64_t bytes() const { return offset_; }  // in the file so far

 private:
  static constexpr std::size_t kChunkBytes = 1u << 20;
  struct Entry {
    std::uint64_t time = 0, offset = 0;
  };
  struct Channel {
    std::vector<std::uint8_t> schema, channel;  // records
    std::uint32_t messages = 0;
    std::vector<Entry> index;  // of the open chunk
  };
  struct Span {  // of times
    std::uint64_t first = 0, last = 0;
    bool any = false;
    void add(std::uint64_t time);
  };
  McapWriter(std::string path, int file) : path_(std::move(path)), file_(file) {}
  Status put(std::span<const std::uint8_t> bytes);
  Status flush();  // the open chunk
  Status put_indices(std::vector<std::uint8_t>& offsets);
  std::vector<std::uint8_t> statistics() const;
  Status put_summary();

  std::string path_;
  int file_ = -1;
  std::uint64_t offset_ = 0;
  std::uint32_t crc_ = 0;  // of what is in the file
  std::map<std::uint16_t, Channel> channels_;
  std::vector<std::uint8_t> chunk_, packed_;
  Span chunk_times_, times_;
  std::vector<std::uint8_t> chunk_indices_;  // records
  std::uint32_t chunks_ = 0;
  std::uint64_t messages_ = 0;
};

}  // namespace onemap::daemon
