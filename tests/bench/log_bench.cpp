// What the log on the disk costs, and what a signature does: bench_log [MB].
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>

#include "comms/disk/disk_store.hpp"
#include "comms/disk/posix_disk.hpp"
#include "support/signed_logs.hpp"
#include "support/temp_folder.hpp"

namespace {
using namespace onemap;
// Processor time, so that other work on the machine does not count; from the page cache there is nothing to wait for.
struct Clock {
  static std::clock_t now() { return std::clock(); }
};
double seconds_since(std::clock_t begin) { return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC; }

void signatures() {
  const comms::Identity author = comms::sim::identity_of(RobotId::from_name("a"));
  constexpr int kTimes = 2000;
  for (const std::size_t bytes : {500u, 13'000u, 100'000u}) {
    Record record{{{RobotId::from_name("a"), 3, 1}, 1}, 4, std::vector<std::uint8_t>(bytes, 7), {}, {}};
    auto begin = Clock::now();
    for (int k = 0; k < kTimes; ++k) comms::seal(record, {}, author);
    const double sealed = seconds_since(begin);
    begin = Clock::now();
    int good = 0;
    for (int k = 0; k < kTimes; ++k)
      good += comms::signed_by(author.public_key(), comms::head_of(record), record.seal.signature) ? 1 : 0;
    const double checked = seconds_since(begin);
    fmt::print("a record of {:6} bytes: sealed in {:.0f} us, looked at in {:.0f} us{}\n", bytes, sealed / kTimes * 1e6,
               checked / kTimes * 1e6, good == kTimes ? "" : " (WRONG)");
  }
}

void log(std::size_t megabytes) {
  const test::TempFolder folder;
  comms::DiskStoreConfig config;
  config.budget_bytes = config.author_bytes = (megabytes * 3 / 2) << 20;
  auto disk = comms::PosixDisk::open(folder / "log");
  const std::size_t records = (megabytes << 20) / 13'000;
  const auto begin = Clock::now();
  {
    auto store = comms::DiskStore::open(**disk, config);
    Record record{{{RobotId::from_name("a"), 3, 1}, 0}, 4, std::vector<std::uint8_t>(13'000, 7), {}, {}};
    for (; record.id.seq < records; ++record.id.seq)
      if (!(*store)->append(record)) std::abort();
    fmt::print("written: {:.0f} MB/s\n", static_cast<double>((*store)->bytes()) / seconds_since(begin) / 1e6);
  }
  for (int round = 0; round < 3; ++round) {
    const auto start = Clock::now();
    auto store = comms::DiskStore::open(**disk, config);
    const double took = seconds_since(start);
    fmt::print("read at the start: {} records, {:.0f} MB/s, {:.1f} MB of memory at most\n", (*store)->view().records,
               static_cast<double>((*store)->bytes()) / took / 1e6,
               static_cast<double>((*store)->view().memory_bytes) / 1e6);
  }
}
}  // namespace

int main(int argc, char** argv) {
  signatures();
  log(argc > 1 ? static_cast<std::size_t>(std::max(1, std::atoi(argv[1]))) : 256);
}
