// A robot's radio on a real socket, beside an honest neighbour, while a stranger floods it: what it answers (nothing),
// what the neighbour's records lose by that, and what it costs.
//   bench_comms_flood [rate=100000] [seconds=10] [mbit=20] [kinds=all] [buffer=0]
// kinds: a list of those in support/garbage.hpp. buffer: of the radio's socket, as SO_RCVBUF (212992 is what Debian
// gives a daemon); 0: what it asks for itself. The radio, its neighbour and the stranger are a process each.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <numeric>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "comms/udp/udp_port.hpp"
#include "daemon/clock.hpp"
#include "daemon/radio.hpp"
#include "support/garbage.hpp"
#include "support/team_key.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using comms::sim::Datagram;
using comms::sim::Garbage;
using std::chrono::steady_clock;

using Words = std::map<std::string, std::string>;
double number(const Words& words, const std::string& key) { return std::stod(words.at(key)); }

comms::TeamKey key_in_file() {  // that test::team_key writes
  std::array<std::uint8_t, 32> bytes;
  bytes.fill(0x55);
  return comms::TeamKey(bytes);
}

// ---- the radio, and its neighbour's

struct Robot {
  daemon::Config config;
  daemon::Failures failures;
  daemon::Log log;
  std::unique_ptr<daemon::Radio> radio;
  std::atomic<std::uint64_t> bytes = 0;  // of bodies that came
  std::mutex mutex;
  std::vector<double> pose_ms;

  Robot(const std::string& id, const std::string& folder, const std::string& key_file) : log(id) {
    config.id = id;
    config.out = folder + "/" + id;
    config.listen = "127.0.0.1:0";
    config.team_key_file = key_file;
    config.key_log = config.out + "/keys";
    config.keep_log = false;  // the disk is measured elsewhere
    config.store_budget_bytes = std::size_t{4} << 30;
    std::filesystem::create_directories(config.out);
  }
  bool open() {
    auto opened = daemon::Radio::open(config,
                                      {[this](const std::shared_ptr<const Record>& record) { applied(*record); },
                                       [] { return true; }, [](std::uint64_t, bool) {}},
                                      failures, log);
    if (!opened) return fmt::print(stderr, "{}\n", opened.error().text()), false;
    radio = std::move(*opened);
    radio->start();
    return true;
  }
  void applied(const Record& record) {
    bytes += record.body.size();
    if (record.id.log.lane != static_cast<std::uint8_t>(mapping::Lane::poses)) return;
    std::int64_t made = 0;
    std::memcpy(&made, record.body.data(), sizeof made);
    const std::lock_guard lock(mutex);
    pose_ms.push_back(1e-6 * static_cast<double>(daemon::now().time_since_epoch().count() - made));
  }
};

// Records of voxels at this pace, and thirty poses a second that say when they were made; until its input ends.
int be_neighbour(const Words& words) {
  Robot robot("neighbour", words.at("folder"), words.at("key"));
  robot.config.peers = {words.at("peer")};
  if (!robot.open()) return 1;
  constexpr std::size_t kVoxelBytes = 60'000, kPoseBytes = 120;
  const auto voxels_every =
      std::chrono::nanoseconds(static_cast<std::int64_t>(8e3 * kVoxelBytes / number(words, "mbit")));
  std::atomic<bool> over = false;
  std::thread watcher([&] { over = std::getchar() == EOF; });
  auto voxels = steady_clock::now(), pose = voxels;
  while (!over) {
    std::this_thread::sleep_until(std::min(voxels, pose));
    if (const auto now = steady_clock::now(); now >= pose) {
      std::vector<std::uint8_t> body(kPoseBytes);
      const std::int64_t made = daemon::now().time_since_epoch().count();
      std::memcpy(body.data(), &made, sizeof made);
      robot.radio->publish({mapping::Lane::poses, mapping::RecordKind::trajectory, std::move(body)});
      pose += 33ms;
    }
    if (steady_clock::now() < voxels) continue;
    robot.radio->publish(
        {mapping::Lane::voxels, mapping::RecordKind::submap, std::vector<std::uint8_t>(kVoxelBytes, 7)});
    voxels += voxels_every;
  }
  watcher.join();
  return 0;
}

// ---- the stranger

struct Sockets {
  static constexpr std::size_t kCount = 16;
  std::vector<int> all;
  explicit Sockets(const comms::Endpoint& to) {
    for (std::size_t i = 0; i < kCount; ++i) {
      const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
      sockaddr_in own = address(comms::Endpoint::ipv4(127, 0, 77, static_cast<std::uint8_t>(1 + i), 0));
      sockaddr_in there = address(to);
      if (::bind(fd, reinterpret_cast<sockaddr*>(&own), sizeof own) != 0 ||
          ::connect(fd, reinterpret_cast<sockaddr*>(&there), sizeof there) != 0)
        fmt::print(stderr, "the stranger has no socket: {}\n", std::strerror(errno));
      all.push_back(fd);
    }
  }
  static sockaddr_in address(const comms::Endpoint& endpoint) {
    sockaddr_in in{};
    in.sin_family = AF_INET;
    in.sin_port = htons(endpoint.port);
    std::memcpy(&in.sin_addr, endpoint.address.data() + 12, 4);
    return in;
  }
  std::size_t answers() const {
    std::size_t n = 0;
    std::array<char, 2048> bytes;
    for (const int fd : all)
      while (::recv(fd, bytes.data(), bytes.size(), 0) >= 0) ++n;
    return n;
  }
};

// Some of each kind, in turns.
std::vector<Datagram> made_before(const Words& words) {
  Garbage garbage(key_in_file(), 1);
  std::ifstream keys(words.at("keys"));
  for (std::string line; std::getline(keys, line);) garbage.overhear(line);
  const std::string& kinds = words.at("kinds");
  std::vector<Datagram> all;
  for (int i = 0; i < 200; ++i)
    for (const auto& [kind, name] : Garbage::kKinds)
      if (kinds == "all" || ("," + kinds + ",").find(fmt::format(",{},", name)) != std::string::npos)
        all.push_back(garbage.make(kind));
  return all;
}

int be_stranger(const Words& words) {
  constexpr std::size_t kBatch = 20;
  const Sockets sockets(*comms::parse_endpoint(words.at("peer")));
  std::vector<Datagram> garbage = made_before(words);
  if (garbage.empty()) return fmt::print(stderr, "no such kind of garbage\n"), 2;
  const auto pause = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * kBatch / number(words, "rate")));
  const auto began = steady_clock::now();
  const auto end = began + std::chrono::duration<double>(number(words, "seconds"));
  std::size_t sent = 0, not_sent = 0, next = 0, turn = 0, answers = 0;
  for (auto due = began; due < end; due += pause, ++turn) {
    std::this_thread::sleep_until(due);
    std::array<mmsghdr, kBatch> headers{};
    std::array<iovec, kBatch> parts{};
    for (std::size_t i = 0; i < kBatch; ++i, next = (next + 1) % garbage.size()) {
      parts[i] = {garbage[next].data(), garbage[next].size()};
      headers[i].msg_hdr.msg_iov = &parts[i];
      headers[i].msg_hdr.msg_iovlen = 1;
    }
    const int n = ::sendmmsg(sockets.all[turn % Sockets::kCount], headers.data(), kBatch, 0);
    sent += static_cast<std::size_t>(std::max(n, 0));
    not_sent += kBatch - static_cast<std::size_t>(std::max(n, 0));
    if (turn % 1000 == 0) answers += sockets.answers();
  }
  const double took = std::chrono::duration<double>(steady_clock::now() - began).count();
  std::this_thread::sleep_for(2s);  // what answers late
  fmt::print("{} {} {} {}\n", sent, not_sent, took, answers + sockets.answers());
  return 0;
}

// ---- who looks on

// What the kernel threw away for want of room in the socket of this port, since it was opened.
std::uint64_t dropped_by_kernel(std::uint16_t port) {
  std::ifstream table("/proc/net/udp");
  const std::string place = fmt::format(":{:04X}", port);
  for (std::string line; std::getline(table, line);) {
    std::istringstream in(line);
    std::string slot, local, word, last;
    in >> slot >> local;
    while (in >> word) last = word;
    if (local.ends_with(place)) return std::stoull(last);
  }
  return 0;
}

// Of this process's threads: how long they worked, and waited for a core that others had.
struct Cores {
  double worked_s = 0, waited_s = 0;
  static Cores used() {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * t.tv_usec; };
    Cores out{seconds(used.ru_utime) + seconds(used.ru_stime), 0};
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
      std::uint64_t ran = 0, waited = 0;
      std::ifstream(task.path() / "schedstat") >> ran >> waited;
      out.waited_s += 1e-9 * static_cast<double>(waited);
    }
    return out;
  }
};

// The socket's buffer as another machine would give it; it is found by its port.
void set_receive_buffer(std::uint16_t port, int bytes) {
  for (int fd = 3; fd < 256; ++fd) {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&own), &size) == 0 && own.sin_family == AF_INET &&
        ntohs(own.sin_port) == port)
      ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  }
}

struct Seen {
  double mbit = 0, pose_p99_ms = 0, refused = 0, dropped = 0, reasked = 0;
  Cores cores;
};

class Watch {
 public:
  Watch(Robot& robot, std::uint16_t port) : robot_(robot), port_(port) {}
  Seen look(double seconds) {
    const Seen before = now();
    {
      const std::lock_guard lock(robot_.mutex);
      robot_.pose_ms.clear();
    }
    const auto began = steady_clock::now();
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    const double took = std::chrono::duration<double>(steady_clock::now() - began).count();
    const Seen after = now();
    return {
        (after.mbit - before.mbit) / took,
        p99(),
        (after.refused - before.refused) / took,
        (after.dropped - before.dropped) / took,
        (after.reasked - before.reasked) / took,
        {(after.cores.worked_s - before.cores.worked_s) / took, (after.cores.waited_s - before.cores.waited_s) / took}};
  }

 private:
  Seen now() const {
    const comms::Counters counters = robot_.radio->view().counters;
    return {static_cast<double>(robot_.bytes) * 8e-6,
            0,
            static_cast<double>(std::accumulate(counters.refused.begin(), counters.refused.end(), std::uint64_t{0})),
            static_cast<double>(dropped_by_kernel(port_)),
            static_cast<double>(counters.fragments_reasked),
            Cores::used()};
  }
  double p99() const {
    const std::lock_guard lock(robot_.mutex);
    auto sorted = robot_.pose_ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted.empty() ? -1 : sorted[sorted.size() * 99 / 100];
  }
  Robot& robot_;
  std::uint16_t port_;
};

void print(const char* name, const Seen& seen) {
  fmt::print("{:<8} {:>9.3f} {:>12.2f} {:>13.1f} {:>12.1f} {:>11.0f} {:>13.0f} {:>14.1f}\n", name, seen.mbit,
             seen.pose_p99_ms, 100 * seen.cores.worked_s, 100 * seen.cores.waited_s, seen.refused, seen.dropped,
             seen.reasked);
  std::fflush(stdout);
}

int run(const Words& words) {
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  const test::TempFolder folder;
  const std::string key = test::team_key(folder);
  Robot robot("robot", folder.path(), key);
  if (!robot.open()) return 1;
  const std::string local = robot.radio->local();
  const std::uint16_t port = comms::parse_endpoint(local)->port;
  if (const int buffer = std::stoi(words.at("buffer")); buffer > 0) set_receive_buffer(port, buffer);
  std::FILE* const neighbour = ::popen(fmt::format("{} neighbour folder={} key={} peer={} mbit={}", self,
                                                   folder.path().string(), key, local, words.at("mbit"))
                                           .c_str(),
                                       "w");
  while (robot.bytes == 0) std::this_thread::sleep_for(10ms);
  std::this_thread::sleep_for(2s);
  const double seconds = number(words, "seconds");
  fmt::print("{:<8} {:>9} {:>12} {:>13} {:>12} {:>11} {:>13} {:>14}\n", "", "Mbit/s", "pose p99 ms", "core worked %",
             "and waited %", "refused/s", "kernel drop/s", "asked again/s");
  Watch watch(robot, port);
  const Seen before = watch.look(seconds);
  print("calm", before);
  std::FILE* const stranger =
      ::popen(fmt::format("{} stranger peer={} keys={} rate={} seconds={} kinds={}", self, local, robot.config.key_log,
                          words.at("rate"), seconds + 2, words.at("kinds"))
                  .c_str(),
              "r");
  std::this_thread::sleep_for(1s);
  const Seen flooded = watch.look(seconds);
  print("flooded", flooded);
  std::size_t sent = 0, not_sent = 0, answers = 0;
  double took = 1;
  const bool told = std::fscanf(stranger, "%zu %zu %lf %zu", &sent, &not_sent, &took, &answers) == 4;
  ::pclose(stranger);
  const Seen after = watch.look(seconds);
  print("calm", after);
  ::pclose(neighbour);
  robot.radio->stop();
  if (!told) return 1;
  fmt::print(
      "sent {} in {:.1f} s, {:.0f} a second ({} were not taken by the kernel); answers {}; goodput {:.1f} % of calm\n",
      sent, took, static_cast<double>(sent) / took, not_sent, answers, 200 * flooded.mbit / (before.mbit + after.mbit));
  return answers == 0 ? 0 : 1;
}

}  // namespace
}  // namespace onemap

int main(int argc, char** argv) {
  onemap::Words words{{"rate", "100000"}, {"seconds", "10"}, {"mbit", "20"}, {"kinds", "all"}, {"buffer", "0"}};
  const std::string part = argc > 1 ? argv[1] : "";
  const bool child = part == "neighbour" || part == "stranger";
  for (int i = child ? 2 : 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto equals = word.find('=');
    if (equals == std::string::npos || (!child && !words.contains(word.substr(0, equals)))) {
      fmt::print(stderr, "bench_comms_flood: unknown argument '{}'\n", word);
      return 2;
    }
    words[word.substr(0, equals)] = word.substr(equals + 1);
  }
  if (part == "neighbour") return onemap::be_neighbour(words);
  return part == "stranger" ? onemap::be_stranger(words) : onemap::run(words);
}
