// MCAP files by the letter of the specification (mcap.dev/spec): a reader that takes nothing for granted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

#include <bit>
#include <nlohmann/json.hpp>
#include <set>

#include "daemon/mcap/foxglove.hpp"
#include "daemon/mcap/mcap_recording.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/base/bytes.hpp"
#include "hal/base/file.hpp"
#include "hal/imaging/image_file.hpp"
#include "support/other_program.hpp"
#include "support/temp_folder.hpp"

namespace onemap::daemon {
namespace {

using test::TempFolder;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;
using McapJson = nlohmann::json;

struct McapRecord {
  std::uint8_t op = 0;
  std::span<const std::uint8_t> content;
  std::uint64_t offset = 0, length = 0;  // with its head, from the start of what it is in
};

std::vector<McapRecord> records(std::span<const std::uint8_t> bytes, std::uint64_t from = 0) {
  std::vector<McapRecord> found;
  ByteReader in(bytes);
  while (in.remaining() > 0) {
    McapRecord record;
    record.offset = from + bytes.size() - in.remaining();
    record.op = in.get<std::uint8_t>();
    const auto length = in.get<std::uint64_t>();
    record.content = in.bytes(length);
    record.length = 9 + length;
    if (!in.ok()) throw std::runtime_error("a record is cut short");
    found.push_back(record);
  }
  return found;
}

std::string string_of(ByteReader& in) {
  const auto bytes = in.bytes(in.get<std::uint32_t>());
  return {bytes.begin(), bytes.end()};
}
template <class Key, class Value>
std::map<Key, Value> map_of(ByteReader& in) {
  ByteReader inner(in.bytes(in.get<std::uint32_t>()));
  std::map<Key, Value> map;
  while (inner.remaining() > 0) {
    const auto key = inner.get<Key>();
    EXPECT_TRUE(map.emplace(key, inner.get<Value>()).second) << "a key twice";
  }
  EXPECT_TRUE(inner.ok());
  return map;
}

// zlib's, slowly and otherwise than ours.
std::uint32_t slow_crc(std::span<const std::uint8_t> bytes) {
  std::uint32_t c = 0xffffffff;
  for (const std::uint8_t b : bytes)
    for (int bit = 0; bit < 8; ++bit) {
      const std::uint32_t low = (c ^ (static_cast<std::uint32_t>(b) >> bit)) & 1;
      c = (c >> 1) ^ (low != 0 ? 0xedb88320u : 0);
    }
  return ~c;
}

struct Message {
  std::string topic, schema;
  std::uint32_t sequence = 0;
  std::uint64_t time = 0;
  McapJson json;
};

// Everything that the specification says of a chunked, indexed file is checked while it is read.
class StrictReader {
 public:
  explicit StrictReader(const std::string& path) : file_(*read_file(path)) {
    constexpr std::uint8_t kMagic[] = {0x89, 'M', 'C', 'A', 'P', 0x30, '\r', '\n'};
    if (file_.size() < 16 || !std::equal(kMagic, kMagic + 8, file_.begin()) ||
        !std::equal(kMagic, kMagic + 8, file_.end() - 8))
      throw std::runtime_error("no magic");
    const auto all = records(std::span(file_).subspan(8, file_.size() - 16), 8);
    if (all.front().op != 0x01 || all.back().op != 0x02) throw std::runtime_error("no header or footer");
    std::size_t at = 1;
    while (all[at].op != 0x0f) data(all, at);
    ByteReader end(all[at].content);
    EXPECT_EQ(end.get<std::uint32_t>(), slow_crc(std::span(file_).first(all[at].offset))) << "data section's CRC";
    EXPECT_TRUE(end.done());
    summary(std::vector<McapRecord>(all.begin() + static_cast<std::ptrdiff_t>(at) + 1, all.end()));
  }
  const std::vector<Message>& messages() const { return messages_; }
  std::size_t chunks() const { return chunks_.size(); }

 private:
  struct Chunk {
    McapRecord record;
    std::uint64_t first = 0, last = 0, packed = 0, size = 0, index_length = 0;
    std::map<std::uint16_t, std::uint64_t> indices;
  };
  void data(const std::vector<McapRecord>& all, std::size_t& at) {
    if (all[at].op != 0x06) throw std::runtime_error("in an indexed file messages are in chunks");
    Chunk chunk{all[at], 0, 0, 0, 0, 0, {}};
    ByteReader in(all[at].content);
    chunk.first = in.get<std::uint64_t>();
    chunk.last = in.get<std::uint64_t>();
    chunk.size = in.get<std::uint64_t>();
    const auto crc = in.get<std::uint32_t>();
    EXPECT_EQ(string_of(in), "zstd");
    const auto packed = in.bytes(chunk.packed = in.get<std::uint64_t>());
    EXPECT_TRUE(in.done());
    Bytes content(chunk.size);
    if (ZSTD_decompress(content.data(), content.size(), packed.data(), packed.size()) != content.size())
      throw std::runtime_error("a chunk of another size than it says");
    EXPECT_EQ(crc, slow_crc(content)) << "chunk's CRC";
    std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> expected;
    std::uint64_t first = UINT64_MAX, last = 0;
    for (const McapRecord& record : records(content)) {
      take(record);
      if (record.op != 0x05) continue;
      first = std::min(first, messages_.back().time);
      last = std::max(last, messages_.back().time);
      expected[channel_].emplace_back(messages_.back().time, record.offset);
    }
    EXPECT_EQ(chunk.first, first);
    EXPECT_EQ(chunk.last, last);
    for (++at; all[at].op == 0x07; ++at) {
      ByteReader index(all[at].content);
      const auto id = index.get<std::uint16_t>();
      ByteReader entries(index.bytes(index.get<std::uint32_t>()));
      EXPECT_TRUE(index.done());
      std::vector<std::pair<std::uint64_t, std::uint64_t>> found;
      while (entries.remaining() > 0) {
        const auto time = entries.get<std::uint64_t>();
        found.emplace_back(time, entries.get<std::uint64_t>());
      }
      EXPECT_EQ(found, expected[id]);
      EXPECT_TRUE(chunk.indices.emplace(id, all[at].offset).second) << "one index a channel";
      chunk.index_length += all[at].length;
    }
    EXPECT_EQ(chunk.indices.size(), expected.size());
    chunks_.push_back(std::move(chunk));
  }
  void take(const McapRecord& record) {
    ByteReader in(record.content);
    const auto id = in.get<std::uint16_t>();
    if (record.op == 0x03) {
      EXPECT_NE(id, 0);
      schemas_[id] = string_of(in);
      EXPECT_EQ(string_of(in), "jsonschema");
      EXPECT_FALSE(McapJson::parse(string_of(in), nullptr, false).is_discarded());
      schema_records_.emplace_back(record.content.begin(), record.content.end());
    } else if (record.op == 0x04) {
      const auto schema = in.get<std::uint16_t>();
      if (!schemas_.contains(schema)) throw std::runtime_error("a channel before its schema");
      channels_[id] = {string_of(in), schemas_[schema]};
      EXPECT_EQ(string_of(in), "json");
      EXPECT_TRUE((map_of<std::uint8_t, std::uint8_t>(in).empty())) << "no metadata";
      channel_records_.emplace_back(record.content.begin(), record.content.end());
    } else if (record.op == 0x05) {
      if (!channels_.contains(id)) throw std::runtime_error("a message before its channel");
      channel_ = id;
      Message message{channels_[id].first, channels_[id].second, in.get<std::uint32_t>(), in.get<std::uint64_t>(), {}};
      EXPECT_EQ(in.get<std::uint64_t>(), message.time) << "published when logged";
      EXPECT_EQ(message.sequence, counts_[id]++);
      const auto data = in.bytes(in.remaining());
      message.json = McapJson::parse(data.begin(), data.end());
      messages_.push_back(std::move(message));
      return;
    } else {
      throw std::runtime_error("what a chunk must not hold");
    }
    EXPECT_TRUE(in.done());
  }
  void summary(const std::vector<McapRecord>& all) {
    std::vector<Bytes> schemas, channels;
    std::map<std::uint8_t, std::pair<std::uint64_t, std::uint64_t>> groups;
    std::size_t chunk = 0, statistics = 0;
    std::uint64_t offsets = 0;
    std::uint8_t last_op = 0;
    for (std::size_t i = 0; i + 1 < all.size(); ++i) {
      const McapRecord& r = all[i];
      if (r.op == 0x0e) {
        if (offsets == 0) offsets = r.offset;
        ByteReader in(r.content);
        const auto op = in.get<std::uint8_t>();
        const auto start = in.get<std::uint64_t>();
        EXPECT_EQ(groups[op], std::pair(start, in.get<std::uint64_t>()));
        groups.erase(op);
        EXPECT_TRUE(in.done());
        continue;
      }
      EXPECT_EQ(offsets, 0u) << "offsets come last";
      EXPECT_TRUE(r.op == last_op || !groups.contains(r.op)) << "grouped by opcode";
      if (groups[last_op = r.op].second == 0) groups[r.op].first = r.offset;
      groups[r.op].second += r.length;
      if (r.op == 0x03) schemas.emplace_back(r.content.begin(), r.content.end());
      if (r.op == 0x04) channels.emplace_back(r.content.begin(), r.content.end());
      if (r.op == 0x08) chunk_index(r, chunks_.at(chunk++));
      if (r.op == 0x0b) check_statistics(r, ++statistics);
    }
    EXPECT_TRUE(groups.empty()) << "each group has its offset";
    for (auto* some : {&schemas, &schema_records_, &channels, &channel_records_}) std::ranges::sort(*some);
    EXPECT_TRUE(schemas == schema_records_) << "duplicates of those in the data section";
    EXPECT_TRUE(channels == channel_records_) << "duplicates of those in the data section";
    EXPECT_EQ(chunk, chunks_.size());
    EXPECT_EQ(statistics, 1u);
    ByteReader footer(all.back().content);
    const auto start = footer.get<std::uint64_t>();
    EXPECT_EQ(start, all.front().offset);
    EXPECT_EQ(footer.get<std::uint64_t>(), offsets);
    const std::uint64_t end = all.back().offset + 9 + 16;
    EXPECT_EQ(footer.get<std::uint32_t>(), slow_crc(std::span(file_).subspan(start, end - start))) << "summary's CRC";
    EXPECT_TRUE(footer.done());
  }
  void chunk_index(const McapRecord& record, const Chunk& chunk) {
    ByteReader in(record.content);
    EXPECT_EQ(in.get<std::uint64_t>(), chunk.first);
    EXPECT_EQ(in.get<std::uint64_t>(), chunk.last);
    EXPECT_EQ(in.get<std::uint64_t>(), chunk.record.offset);
    EXPECT_EQ(in.get<std::uint64_t>(), chunk.record.length);
    EXPECT_EQ((map_of<std::uint16_t, std::uint64_t>(in)), chunk.indices);
    EXPECT_EQ(in.get<std::uint64_t>(), chunk.index_length);
    EXPECT_EQ(string_of(in), "zstd");
    EXPECT_EQ(in.get<std::uint64_t>(), chunk.packed);
    EXPECT_EQ(in.get<std::uint64_t>(), chunk.size);
    EXPECT_TRUE(in.done());
  }
  void check_statistics(const McapRecord& record, std::size_t) {
    ByteReader in(record.content);
    EXPECT_EQ(in.get<std::uint64_t>(), messages_.size());
    EXPECT_EQ(in.get<std::uint16_t>(), schema_records_.size());
    EXPECT_EQ(in.get<std::uint32_t>(), channel_records_.size());
    EXPECT_EQ(in.get<std::uint32_t>(), 0u);
    EXPECT_EQ(in.get<std::uint32_t>(), 0u);
    EXPECT_EQ(in.get<std::uint32_t>(), chunks_.size());
    std::uint64_t first = messages_.empty() ? 0 : UINT64_MAX, last = 0;
    for (const Message& message : messages_) {
      first = std::min(first, message.time);
      last = std::max(last, message.time);
    }
    EXPECT_EQ(in.get<std::uint64_t>(), first);
    EXPECT_EQ(in.get<std::uint64_t>(), last);
    const auto counts = map_of<std::uint16_t, std::uint64_t>(in);
    EXPECT_EQ(counts.size(), counts_.size());
    for (const auto& [id, count] : counts) EXPECT_EQ(count, counts_[id]);
    EXPECT_TRUE(in.done());
  }

  const Bytes file_;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, std::pair<std::string, std::string>> channels_;
  std::map<std::uint16_t, std::uint32_t> counts_;
  std::uint16_t channel_ = 0;
  std::vector<Bytes> schema_records_, channel_records_;
  std::vector<Message> messages_;
  std::vector<Chunk> chunks_;
};

TEST(Mcap, TheChecksumIsZlibs) {
  const std::string text = "123456789";
  EXPECT_EQ(crc32(0, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}), 0xcbf43926u);
  EXPECT_EQ(crc32(0, {}), 0u);
}

TEST(Mcap, FilesOfNoneOneAndManyChunksAreAsSpecified) {
  const TempFolder folder;
  for (const int messages : {0, 1, 3000}) {
    const std::string path = folder / (std::to_string(messages) + ".mcap");
    auto writer = McapWriter::create(path, "test");
    ASSERT_TRUE(writer) << writer.error().text();
    const auto a = writer->add_channel("/a", "A", R"({"type":"object"})");
    const auto b = writer->add_channel("/b", "B", R"({"type":"object"})");
    writer->add_channel("/never", "C", "{}");
    const std::string filling(900, 'x');
    for (int i = 0; i < messages; ++i)
      ASSERT_TRUE(writer->write(i % 3 == 0 ? b : a, frame_time_from_ns(1'000'000 + (i ^ 1) * 1000),
                                McapJson{{"i", i}, {"filling", filling}}.dump()));
    ASSERT_TRUE(writer->finish());
    EXPECT_EQ(writer->bytes(), std::filesystem::file_size(path));
    const StrictReader read(path);
    ASSERT_EQ(read.messages().size(), static_cast<std::size_t>(messages));
    EXPECT_EQ(read.chunks(), messages == 3000 ? 3u : static_cast<std::size_t>(messages));
    for (int i = 0; i < messages; ++i) {
      EXPECT_EQ(read.messages()[static_cast<std::size_t>(i)].json.at("i"), i);
      EXPECT_EQ(read.messages()[static_cast<std::size_t>(i)].topic, i % 3 == 0 ? "/b" : "/a");
    }
  }
  EXPECT_THAT(McapWriter::create(folder / "0.mcap", "test").error().text(), HasSubstr("File exists"));
}

TEST(Mcap, Base64IsTheStandards) {
  const auto of = [](std::string_view text) {
    return base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
  EXPECT_EQ(of("\xff\xef\xbe"), "/+++");
}

Bytes from_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  Bytes bytes;
  std::uint32_t v = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    v = (v << 6) | static_cast<std::uint32_t>(digits.find(c));
    if ((bits += 6) >= 8) bytes.push_back(static_cast<std::uint8_t>(v >> (bits -= 8)));
  }
  return bytes;
}

// Two frames and two poses of a walk.
std::string recorded_walk(const TempFolder& folder) {
  const std::string path = folder / "walk.mcap";
  auto recording = McapRecording::create(path);
  auto camera = hal::open_simulated(*hal::parse_camera_address("simulated:office?width=64&height=48&noise=none"));
  hal::FramePool pool((*camera)->intrinsics(), 1);
  hal::Frame frame = pool.acquire();
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ((*camera)->grab(frame, {}), hal::Grab::frame);
    EXPECT_TRUE(recording->write(frame.view()));
    RecordedPose pose{frame.colour_time, {mapping::Matrix3d::Identity(), {1, 2, 3}}, std::nullopt};
    if (i == 1) pose.T_map_odom = mapping::Pose{mapping::Matrix3d::Identity(), {10, 0, 0}};
    EXPECT_TRUE(recording->write(pose));
  }
  EXPECT_TRUE(recording->finish());
  return path;
}

TEST(Mcap, ARecordingHasPicturesPointsAndPosesOfFoxglovesSchemas) {
  const TempFolder folder;
  const StrictReader read(recorded_walk(folder));
  std::map<std::string, std::vector<const Message*>> topics;
  for (const Message& message : read.messages()) topics[message.topic].push_back(&message);
  ASSERT_EQ(topics["/camera/image"].size(), 2u);
  const Message& image = *topics["/camera/image"][1];
  EXPECT_EQ(image.schema, "foxglove.CompressedImage");
  EXPECT_EQ(image.time, 1'600'000'000'033'333'333u);
  EXPECT_EQ(image.json.at("timestamp"), (McapJson{{"sec", 1600000000}, {"nsec", 33333333}}));
  EXPECT_EQ(image.json.at("format"), "jpeg");
  const auto size = hal::imaging::image_size(from_base64(image.json.at("data")));
  ASSERT_TRUE(size);
  EXPECT_EQ(*size, (hal::imaging::ImageSize{64, 48}));

  ASSERT_EQ(topics["/camera/points"].size(), 1u);
  const McapJson& cloud = topics["/camera/points"][0]->json;
  EXPECT_EQ(topics["/camera/points"][0]->schema, "foxglove.PointCloud");
  EXPECT_EQ(cloud.at("point_stride"), 16);
  EXPECT_EQ(cloud.at("fields").size(), 7u);
  EXPECT_EQ(cloud.at("fields").at(3), (McapJson{{"name", "red"}, {"offset", 12}, {"type", 1}}));
  const Bytes points = from_base64(cloud.at("data"));
  EXPECT_EQ(points.size(), 16u * 16 * 12) << "a room without holes";
  ByteReader in(points);
  const auto x = std::bit_cast<float>(in.get<std::uint32_t>()), y = std::bit_cast<float>(in.get<std::uint32_t>()),
             z = std::bit_cast<float>(in.get<std::uint32_t>());
  EXPECT_GT(z, 0.3f);
  EXPECT_NEAR(x / z, -31.5f / 52.5f, 1e-5f);
  EXPECT_NEAR(y / z, -23.5f / 52.5f, 1e-5f);

  ASSERT_EQ(topics["/pose/odom"].size(), 2u);
  EXPECT_EQ(topics["/pose/odom"][0]->json.at("pose").at("position"), (McapJson{{"x", 1.0}, {"y", 2.0}, {"z", 3.0}}));
  ASSERT_EQ(topics["/pose/map"].size(), 1u);
  EXPECT_EQ(topics["/pose/map"][0]->json.at("pose").at("position").at("x"), 11.0);
  ASSERT_EQ(topics["/tf"].size(), 3u);
  EXPECT_EQ(topics["/tf"][2]->schema, "foxglove.FrameTransform");
  EXPECT_EQ(topics["/tf"][2]->json.at("parent_frame_id"), "map");
  EXPECT_EQ(topics["/tf"][2]->json.at("child_frame_id"), "odom");
  EXPECT_EQ(topics["/tf"][2]->json.at("rotation").at("w"), 1.0);
}

TEST(Mcap, SomebodyElsesReaderTakesIt) {
  const std::string python = test::python_with("mcap");
  if (python.empty()) GTEST_SKIP() << "no python3 with the module mcap here";
  const TempFolder folder;
  const auto said = test::say(python +
                              " -c \"from mcap.reader import make_reader; import sys; print(sum(1 for _ in "
                              "make_reader(open(sys.argv[1], 'rb'), validate_crcs=True).iter_messages()))\" " +
                              recorded_walk(folder));
  EXPECT_EQ(said.status, 0) << said.output;
  EXPECT_EQ(said.output, "9\n");
}

}  // namespace
}  // namespace onemap::daemon
