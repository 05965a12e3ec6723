// One sender, one receiver, an emulated link of 20 Mbit/s and 5 ms between two network namespaces: ours, TCP CUBIC, TCP
// BBR, ENet and NORM, each over losses from 0 to 30 % each way. Medians over seeds, and ratios to ours.
//   bench_net [seconds=8] [seeds=3] [losses=0,1,5,10,20,30] [peers=onemap,cubic,bbr,enet,norm] [queue=1000000]
//             [poses_ms=33]
//   bench_net share [seconds=30]: two of ours, and ours beside TCP CUBIC, on one link
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "support/emulated_net.hpp"

namespace {
using onemap::Duration;
using onemap::to_seconds;
using onemap::test::EmulatedNet;
using onemap::test::LinkTraits;

struct Options {
  std::map<std::string, std::string> words{{"seconds", "8"},
                                           {"seeds", "3"},
                                           {"losses", "0,1,5,10,20,30"},
                                           {"peers", "onemap,cubic,bbr,enet,norm"},
                                           {"queue", "1000000"},
                                           {"mbit", "20"},
                                           {"delay_ms", "5"},
                                           {"poses_ms", "33"}};
  double number(const std::string& key) const { return std::stod(words.at(key)); }
  std::vector<std::string> list(const std::string& key) const {
    std::vector<std::string> out;
    std::istringstream in(words.at(key));
    for (std::string word; std::getline(in, word, ',');) out.push_back(word);
    return out;
  }
};

struct Result {
  double mbit = 0, queue_p95_ms = 0, pose_p99_ms = -1, wire = 0, duplicates = 0;
  bool here = false;
};

// A program in a namespace whose line of output is read when it ends.
class Program {
 public:
  Program(const EmulatedNet& net, std::size_t where, std::vector<std::string> arguments) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) return;
    read_ = ends[0];
    arguments.insert(arguments.begin(), ONEMAP_NET_PEER);
    child_ = net.start(where, arguments, ends[1]);
    close(ends[1]);
  }
  ~Program() {
    if (child_ > 0) {
      kill(child_, SIGKILL);
      waitpid(child_, nullptr, 0);
    }
    if (read_ >= 0) close(read_);
  }
  nlohmann::json result() {
    std::string text;
    std::array<char, 4096> buffer;
    for (ssize_t n; (n = read(read_, buffer.data(), buffer.size())) > 0;)
      text.append(buffer.data(), static_cast<std::size_t>(n));
    waitpid(child_, nullptr, 0);
    child_ = -1;
    return nlohmann::json::parse(text, nullptr, false);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

 private:
  pid_t child_ = -1;
  int read_ = -1;
};

double p95_ms(std::vector<Duration> queues) {
  if (queues.empty()) return 0.0;
  std::sort(queues.begin(), queues.end());
  return 1e3 * to_seconds(queues[queues.size() * 95 / 100]);
}

LinkTraits traits_of(const Options& options, double loss) {
  LinkTraits traits;
  traits.bits_per_second = 1e6 * options.number("mbit");
  traits.delay = Duration(static_cast<std::int64_t>(1e6 * options.number("delay_ms")));
  traits.loss = loss;
  traits.queue_bytes = static_cast<std::size_t>(options.number("queue"));
  return traits;
}

std::unique_ptr<EmulatedNet> open(const LinkTraits& traits, std::uint64_t seed) {
  auto net = EmulatedNet::open(2, {{0, 1, traits, traits}}, seed);
  if (net) return std::move(*net);
  fmt::print("not on this machine: {}\n", net.error().text());
  std::exit(77);
}

std::vector<std::string> side(const EmulatedNet& net, const std::string& peer, bool sends, double seconds) {
  return {peer, sends ? "send" : "receive", net.address(0, sends ? 0 : 1), net.address(0, sends ? 1 : 0),
          fmt::format("{}", seconds)};
}

Result transfer(const Options& options, const std::string& peer, double loss, std::uint64_t seed) {
  const auto net = open(traits_of(options, loss), seed);
  net->keep_queues(0);
  const double seconds = options.number("seconds");
  const auto words = [&](bool sends) {
    auto all = side(*net, peer, sends, seconds);
    all.push_back(options.words.at("poses_ms"));
    return all;
  };
  Program receiver(*net, 1, words(false));
  Program sender(*net, 0, words(true));
  const auto said = receiver.result();
  Result result;
  if (!said.is_object()) return result;
  result.here = true;
  result.mbit = said["mbit"];
  result.pose_p99_ms = said["pose_p99_ms"];
  result.duplicates = said["duplicates"];
  result.queue_p95_ms = p95_ms(net->queues(0));
  const double useful = said["bytes"];
  result.wire = useful == 0 ? 0 : static_cast<double>(net->count(0).bytes + net->count(0, true).bytes) / useful;
  return result;
}

Result median(const std::vector<Result>& runs) {
  Result out;
  const auto middle = [&](auto member) {
    std::vector<double> values;
    for (const Result& run : runs)
      if (run.here) values.push_back(run.*member);
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  };
  out.here = std::any_of(runs.begin(), runs.end(), [](const Result& run) { return run.here; });
  out.mbit = middle(&Result::mbit);
  out.queue_p95_ms = middle(&Result::queue_p95_ms);
  out.pose_p99_ms = middle(&Result::pose_p99_ms);
  out.wire = middle(&Result::wire);
  out.duplicates = middle(&Result::duplicates);
  return out;
}

int compare(const Options& options) {
  fmt::print("{} Mbit/s, {} ms, queue {} bytes, {} s a run, medians of {}\n", options.words.at("mbit"),
             options.words.at("delay_ms"), options.words.at("queue"), options.words.at("seconds"),
             options.words.at("seeds"));
  fmt::print("{:>6} {:>8} {:>9} {:>12} {:>14} {:>13} {:>13} {:>11}\n", "loss", "peer", "Mbit/s", "ours/theirs",
             "queue p95 ms", "pose p99 ms", "wire/useful", "twice");
  for (const std::string& loss : options.list("losses")) {
    double ours = 0;
    for (const std::string& peer : options.list("peers")) {
      std::vector<Result> runs;
      for (int seed = 1; seed <= static_cast<int>(options.number("seeds")); ++seed)
        runs.push_back(transfer(options, peer, std::stod(loss) / 100, static_cast<std::uint64_t>(seed)));
      const Result got = median(runs);
      if (!got.here) {
        fmt::print("{:>5}% {:>8} is not here\n", loss, peer);
        continue;
      }
      if (peer == "onemap") ours = got.mbit;
      fmt::print("{:>5}% {:>8} {:>9.2f} {:>12.2f} {:>14.1f} {:>13.1f} {:>13.3f} {:>10.2f}%\n", loss, peer, got.mbit,
                 got.mbit > 0 ? ours / got.mbit : 0.0, got.queue_p95_ms, got.pose_p99_ms, got.wire,
                 100 * got.duplicates);
      std::fflush(stdout);
    }
  }
  return 0;
}

// Two transfers on one link; each receiver counts from its own first bytes, and both run at once.
int share(const Options& options) {
  const double seconds = options.number("seconds");
  for (const std::string other : {"onemap", "cubic", "bbr"}) {
    const auto net = open(traits_of(options, 0), 1);
    net->keep_queues(0);
    const auto first = [&](bool sends) { return side(*net, "onemap", sends, seconds); };
    const auto second = [&](bool sends) {
      auto words = side(*net, other, sends, seconds);
      if (other == "onemap") words[2] += ":7457", words[3] += ":7457";  // ports of their own
      return words;
    };
    Program receiver_1(*net, 1, first(false)), receiver_2(*net, 1, second(false));
    Program sender_1(*net, 0, first(true)), sender_2(*net, 0, second(true));
    const auto one = receiver_1.result(), two = receiver_2.result();
    if (!one.is_object() || !two.is_object()) continue;
    const double a = one["mbit"], b = two["mbit"];
    fmt::print("beside {:>7}: {:.2f} and {:.2f} Mbit/s, our share {:.0f} %, Jain {:.3f}, queue p95 {:.1f} ms\n", other,
               a, b, 100 * a / (a + b), (a + b) * (a + b) / (2 * (a * a + b * b)), p95_ms(net->queues(0)));
    std::fflush(stdout);
  }
  return 0;
}
}  // namespace

int main(int argc, char** argv) {
  Options options;
  bool shares = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto equals = word.find('=');
    if (word == "share") {
      shares = true;
    } else if (equals == std::string::npos || !options.words.contains(word.substr(0, equals))) {
      fmt::print(stderr, "bench_net: unknown argument '{}'\n", word);
      return 2;
    } else {
      options.words[word.substr(0, equals)] = word.substr(equals + 1);
    }
  }
  return shares ? share(options) : compare(options);
}
