// net_peer PROTOCOL send|receive HERE THERE SECONDS [no-poses|POSE_EVERY_MS]: one side of a transfer; see peer.hpp.
#include "peer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace onemap::bench {

void Tally::print(double duplicates) const {
  auto sorted = latencies_ms_;
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&](double share) {
    return sorted.empty() ? -1.0 : sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  };
  fmt::print(
      "{{\"mbit\": {:.4f}, \"bytes\": {}, \"poses\": {}, \"pose_p50_ms\": {:.3f}, \"pose_p99_ms\": {:.3f}, "
      "\"duplicates\": {:.5f}}}\n",
      static_cast<double>(bytes_) * 8e-6 / seconds_, bytes_, sorted.size(), at(0.5), at(0.99), duplicates);
  std::fflush(stdout);
}

}  // namespace onemap::bench

int main(int argc, char** argv) {
  using namespace onemap::bench;
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() < 5 || (words[1] != "send" && words[1] != "receive")) {
    fmt::print(stderr,
               "usage: net_peer onemap|cubic|bbr|enet|norm send|receive HERE THERE SECONDS [no-poses|POSE_EVERY_MS]\n");
    return 2;
  }
  Job job{words[1] == "send", words[2], words[3], std::stod(words[4]), words[0], true};
  if (words.size() > 5 && words[5] == "no-poses")
    job.poses = false;
  else if (words.size() > 5)
    job.pose_every = std::chrono::milliseconds(std::stoi(words[5]));
  if (words[0] == "onemap") return run_onemap(job);
  if (words[0] == "cubic" || words[0] == "bbr") return run_tcp(job);
#ifdef ONEMAP_HAVE_ENET
  if (words[0] == "enet") return run_enet(job);
#endif
#ifdef ONEMAP_HAVE_NORM
  if (words[0] == "norm") return run_norm(job);
#endif
  return 77;  // not here
}
