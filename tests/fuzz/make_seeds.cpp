// Writes the first inputs of the corpora: onemap_fuzz_seeds FOLDER. What libFuzzer finds comes beside them.
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "comms/record_head.hpp"
#include "comms/wire.hpp"
#include "comms/wire/payload.hpp"
#include "daemon/saved_map.hpp"
#include "hal/imaging/encode_image.hpp"
#include "mapping/records/finished.hpp"
#include "mapping/records/frontier.hpp"
#include "mapping/records/hello.hpp"
#include "mapping/records/keyframe.hpp"
#include "mapping/records/kind.hpp"
#include "mapping/records/link.hpp"
#include "mapping/records/ruling.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/submap.hpp"
#include "mapping/records/trajectory.hpp"

namespace {
using namespace onemap;
using Bytes = std::vector<std::uint8_t>;
std::filesystem::path folder;

void write(const std::string& target, const std::string& name, const Bytes& bytes) {
  std::filesystem::create_directories(folder / target);
  std::ofstream(folder / target / name, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}
Bytes of(const std::string& text) { return {text.begin(), text.end()}; }

template <class Write>
Bytes datagram(std::uint32_t counter, Write write_frames) {
  std::array<std::uint8_t, comms::kMaxDatagramBytes> buffer{};
  comms::wire::Encoder out(buffer, {comms::wire::DatagramType::unicast, 5, 7, counter});
  write_frames(out);
  return {buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(out.size())};
}

void wire_seeds() {
  using namespace comms::wire;
  const LogId log{RobotId::from_name("friend"), 1, 5};
  Record record{{log, 0}, 3, {1, 2, 3, 4}, {}, {}};
  comms::seal(record, {}, comms::Identity(comms::SecretSeed{2}));
  FragmentBuffer scratch;
  const std::array have{HaveEntry{log, 2}};
  const std::array want{WantEntry{{{RobotId::from_name("self"), 1, 7}, 0}, 0, 3}};
  const std::array robots{comms::RobotStatus{RobotId::from_name("third"), 9, 3, 1, 2, 1}};
  Data data;
  data.id = {log, 0};
  data.kind = 3;
  data.total_bytes = payload_bytes(record);
  data.body_hash = payload_hash(record);
  data.bytes = fragment_of(record, 0, scratch);
  Head head;
  head.record = comms::head_of(record);
  head.by.head = head.record;
  head.by.head.id.seq = head.record.id.seq + 1;
  Mass mass;
  mass.heard = 60'000, mass.neighbours = 2, mass.round = 1u << 24, mass.clock_ns = 1'700'000'000'000'000'000,
  mass.has_amounts = true;
  mass.given.fill({0.5, 0.25});
  const std::vector<std::pair<std::string, Bytes>> all{
      {"beacon", datagram(1,
                          [&](Encoder& out) {
                            out.beacon({RobotId::from_name("friend"), 1, 2, 1, 0});
                          })},
      {"status", datagram(2, [&](Encoder& out) { out.status(robots); })},
      {"have", datagram(3, [&](Encoder& out) { out.have(5, have); })},
      {"have_request", datagram(4, [&](Encoder& out) { out.have_request(); })},
      {"want", datagram(5, [&](Encoder& out) { out.want(5000, want); })},
      {"data", datagram(6, [&](Encoder& out) { out.data(data); })},
      {"head", datagram(9, [&](Encoder& out) { out.head(head); })},
      {"feedback", datagram(10,
                            [&](Encoder& out) {
                              out.feedback({1, 1, 5, 5});
                            })},
      {"mass", datagram(11, [&](Encoder& out) { out.mass(mass); })},
      {"ping", datagram(7, [&](Encoder& out) { out.ping(9), out.pong(8); })},
      {"later_life", datagram(8, [&](Encoder& out) {
         out.later_life({RobotId::from_name("self"), 70});
       })}};
  Bytes talk;
  for (const auto& [name, bytes] : all) {
    write("datagram", name, bytes);
    Bytes one{bytes[kHeaderBytes]};
    one.insert(one.end(), bytes.begin() + kHeaderBytes + kFrameHeadBytes, bytes.end());
    write("frame", name, one);
    talk.insert(talk.end(), {static_cast<std::uint8_t>(bytes.size()), 1, 20});
    talk.insert(talk.end(), bytes.begin(), bytes.end());
    write("node", name, talk);
  }
}

Bytes record(mapping::RecordKind kind, const Bytes& body) {
  Bytes out{static_cast<std::uint8_t>(kind)};
  out.insert(out.end(), body.begin(), body.end());
  return out;
}

void record_seeds() {
  using namespace mapping;
  write("record", "hello", record(RecordKind::hello, encode(HelloRecord{"r1", "tum:/data"})));
  KeyframeRecord keyframe;
  keyframe.index = 3;
  keyframe.features.resize(2);
  for (auto& feature : keyframe.features) feature.place = {5, 6, 7}, feature.laplacian = 1;
  keyframe.grid.fx_fy_cx_cy = {1 << 17, 1 << 17, 5, 7};
  keyframe.grid.width = 4, keyframe.grid.height = 3;
  keyframe.grid.inverse_depth.assign(12, DepthGrid::kFarthest);
  write("record", "keyframe", record(RecordKind::keyframe, encode(keyframe)));
  TrajectoryRecord trajectory;
  for (int i = 1; i < 4; ++i) trajectory.poses.push_back({frame_time_from_ns(i * 1000), {}});
  write("record", "trajectory", record(RecordKind::trajectory, encode(trajectory)));
  SubmapRecord submap{1, 20000, 60000, {}};
  SubmapBlock block;
  block.key = {1, -2, 3};
  for (int i = 0; i < 200; ++i)
    block.voxels[static_cast<std::size_t>(i)].tsdf = 100, block.voxels[static_cast<std::size_t>(i)].weight = 3;
  submap.blocks.push_back(block);
  write("record", "submap", record(RecordKind::submap, encode(submap)));
  LinkRecord link;
  link.a = RobotId::from_name("r1"), link.b = RobotId::from_name("r2");
  link.incarnation_other = 5, link.supporting_pairs = 1;
  link.reason = LinkReason::accepted;
  link.pairs.push_back({1, 2, 30, {}});
  write("record", "link", record(RecordKind::link, encode(link)));
  write("record", "finished", record(RecordKind::finished, encode(FinishedRecord{})));
  write("record", "frontier", record(RecordKind::frontier, encode(FrontierRecord{})));
  write("record", "ruling", record(RecordKind::ruling, encode(RulingRecord{})));
  write("record", "solution", record(RecordKind::solution, encode(SolutionRecord{})));
}

mapping::VoxelMap small_map() {
  mapping::VoxelMapConfig config;
  config.budget_bytes = 1u << 20;
  config.image_pixels = 0;
  return mapping::VoxelMap(config);
}

void daemon_seeds() {
  write("config", "robot",
        of("[robot]\nid = \"r1\"\nout = \"/tmp/x\"\n[run]\nspeed = \"real\"\nlost_after_s = 20.5\n"));
  write("config", "network",
        of("[network]\nlisten = \"0.0.0.0:7400\"\npeers = [\"10.0.0.2:7400\", \"10.0.0.3:7400\"]\n"
           "group = \"239.1.1.1:7400\"\nbytes_per_second = 4000000\n"));
  write("config", "wrong", of("[network]\nlisten = 5\nnothing = 1\n[map]\nvoxel_m = -1.0\n"));
  write("config", "broken", of("[robot\nid = \"\\u00zz\"\n"));
  write("control", "requests",
        of("{\"class\":\"STATUS\",\"id\":1,\"watch\":true}\n{\"class\":\"SNAPSHOT\",\"path\":\"a\"}\r\n"));
  write("control", "wrong", of("{}\n[]\n{\"class\":5}\n{\"class\":\"STATUS\",\"more\":1,\"id\":[]}\nno json\n\n"));
  write("control", "deep", of(std::string(600, '[') + "\n" + std::string(300, '{') + "\n"));
  mapping::VoxelMap map = small_map();
  mapping::Voxel* const block = map.find_or_add({0, 0, 0});
  for (int i = 0; i < mapping::kBlockVoxels; ++i) block[i].add_tsdf(i * 20 - 5000, 5);
  daemon::SavedPath path;
  path.name = "r1";
  path.poses.resize(2), path.keyframes.resize(1);
  write("saved_map", "block", daemon::save_map("a block", std::array{path}, map));
  write("saved_map", "nothing", daemon::save_map("", {}, small_map()));
  write("saved_map", "up", daemon::save_map("up", {}, map, mapping::UpDirection{{0, 600'000, 800'000}}));
}

void image_seeds() {
  using namespace hal::imaging;
  constexpr std::uint8_t kWidth = 40, kHeight = 6;  // two steps of sixteen pixels, and some more
  Bytes pixels(3u * kWidth * kHeight);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i * 7);
  const auto seed = [](std::uint8_t which, std::uint8_t stride, const Bytes& bytes) {
    Bytes out{which, kWidth, kHeight, stride};
    out.insert(out.end(), bytes.begin(), bytes.end());
    return out;
  };
  const auto some = [&](std::size_t size) {
    return Bytes(pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(size));
  };
  write("image", "yuyv", seed(0, 0, some(2u * kWidth * kHeight)));
  write("image", "uyvy_padded", seed(1, 84, some(84u * kHeight)));
  write("image", "grey", seed(2, 0, some(kWidth * kHeight)));
  write("image", "bayer", seed(3, 0, some(kWidth * kHeight)));
  write("image", "z16", seed(4, 0, some(2u * kWidth * kHeight)));
  write("image", "disparity11", seed(5, 0, some(kWidth * kHeight / 8 * 11)));
  // 9 and 10 are OpenNI2's colour and depth, in the upper half the format and, from 7 on, mirrored.
  write("image", "openni2_rgb_mirrored", seed(9 + 16 * 9, 0, some(3u * kWidth * kHeight)));
  write("image", "openni2_uyvy", seed(9 + 16 * 3, 0, some(2u * kWidth * kHeight)));
  write("image", "openni2_grey_mirrored", seed(9 + 16 * 12, 44, some(44u * kHeight)));
  write("image", "openni2_depth_mirrored", seed(10 + 16 * 7, 84, some(84u * kHeight)));
  // 11 and 12 are a Kinect's packed disparities, to millimetres and by tables.
  write("image", "kinect_mm", seed(11, 0, some(kWidth * kHeight / 8 * 11)));
  write("image", "kinect_tabled", seed(12 + 16 * 3, 0, some(kWidth * kHeight / 8 * 11)));
  // 13 is a calibration file.
  constexpr std::string_view kRig =
      "width 40\nheight 30\nfx 38\nfy 38\ncx 19.5\ncy 14.5\nk1 0.05\ndepth_scale 1000\ndepth_none 65535\n"
      "depth_offset_m 0.01\ndepth_width 48\ndepth_height 32\ndepth_fx 24\ndepth_fy 24\ndepth_cx 23.5\n"
      "depth_cy 15.5\ncolour_from_depth_x 0.02\ncolour_from_depth_y -0.001\ncolour_from_depth_qx 0.0299955\n"
      "colour_from_depth_qw 0.99955\n";
  write("image", "rig", seed(13, 0, Bytes(kRig.begin(), kRig.end())));
  Bytes file;
  const std::vector<std::uint16_t> depth(kWidth * kHeight, 1234);
  if (encode_colour({kWidth, kHeight}, pixels, file)) write("image", "png", seed(6, 0, file));
  if (encode_jpeg({kWidth, kHeight}, pixels, 80, file)) {
    write("image", "jpeg", seed(6, 0, file));
    write("image", "jpeg_plain", seed(8, 0, file));
  }
  if (encode_depth({kWidth, kHeight}, depth, file)) write("image", "depth_png", seed(7, 0, file));
}
}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: onemap_fuzz_seeds FOLDER\n");
    return 2;
  }
  folder = argv[1];
  wire_seeds();
  record_seeds();
  daemon_seeds();
  image_seeds();
}
