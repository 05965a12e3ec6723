#include "support/emulated_net.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

namespace onemap::test {

namespace {
constexpr int kPacketsAtOnce = 32;
constexpr auto kLongestWait = std::chrono::milliseconds(50);

Instant now() { return Instant(std::chrono::steady_clock::now().time_since_epoch()); }
Error failed(const std::string& what) { return {"emulated net", fmt::format("{}: {}", what, std::strerror(errno))}; }

int own_namespace() { return ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC); }

std::string address_text(std::size_t link, bool second) { return fmt::format("10.77.{}.{}", link + 1, second ? 2 : 1); }

// Interface flags, addresses and so on are set on a socket of the interface's namespace.
bool configure(const std::string& name, const std::string& own, const std::string& other) {
  const int s = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const auto set = [&](unsigned long request, auto fill) {
    ifreq ask{};
    std::strncpy(ask.ifr_name, name.c_str(), IFNAMSIZ - 1);
    fill(ask);
    return ::ioctl(s, request, &ask) == 0;
  };
  const auto put_address = [](ifreq& ask, const std::string& text) {
    sockaddr_in in{};
    in.sin_family = AF_INET;
    ::inet_pton(AF_INET, text.c_str(), &in.sin_addr);
    std::memcpy(&ask.ifr_addr, &in, sizeof in);
  };
  const bool done = set(SIOCSIFADDR, [&](ifreq& ask) { put_address(ask, own); }) &&
                    set(SIOCSIFDSTADDR, [&](ifreq& ask) { put_address(ask, other); }) &&
                    set(SIOCSIFTXQLEN, [](ifreq& ask) { ask.ifr_qlen = 2000; }) &&
                    set(SIOCSIFFLAGS, [](ifreq& ask) { ask.ifr_flags = IFF_UP | IFF_RUNNING; });
  ::close(s);
  return done;
}

bool raise_loopback() {
  const int s = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq ask{};
  std::strncpy(ask.ifr_name, "lo", IFNAMSIZ - 1);
  ask.ifr_flags = IFF_UP | IFF_RUNNING;
  const bool done = ::ioctl(s, SIOCSIFFLAGS, &ask) == 0;
  ::close(s);
  return done;
}
}  // namespace

struct EmulatedNet::End {
  int tun = -1;
};

struct EmulatedNet::Late {
  Instant at{};
  std::uint64_t order = 0;
  std::size_t to = 0;
  std::vector<std::uint8_t> bytes;
  static bool later(const Late& a, const Late& b) { return a.at != b.at ? a.at > b.at : a.order > b.order; }
};

EmulatedNet::EmulatedNet() = default;

Result<std::unique_ptr<EmulatedNet>> EmulatedNet::open(std::size_t namespaces, const std::vector<Link>& links,
                                                       std::uint64_t seed) {
  std::unique_ptr<EmulatedNet> net(new EmulatedNet());
  net->links_ = links;
  Status status = success();
  std::thread([&] {  // a thread's namespace ends with it
    for (std::size_t i = 0; i < namespaces && status.ok(); ++i) {
      if (::unshare(CLONE_NEWNET) != 0) {
        status = failed("cannot make a network namespace (root is needed)");
        break;
      }
      net->namespaces_.push_back(own_namespace());
      if (!raise_loopback()) status = failed("cannot raise the loopback device");
    }
    for (std::size_t i = 0; i < links.size() && status.ok(); ++i)
      for (const bool second : {false, true})
        if (status.ok()) status = net->open_end(links[i], i, second);
  })
      .join();
  if (!status.ok()) return status.error();
  Random seeds(seed);
  for (const Link& link : links)
    for (const LinkTraits& traits : {link.there, link.back})
      net->models_.push_back(std::make_unique<LinkModel>(traits, seeds.next()));
  net->thread_ = std::thread(&EmulatedNet::run, net.get());
  return net;
}

Status EmulatedNet::open_end(const Link& link, std::size_t number, bool second) {
  if (::setns(namespaces_[second ? link.b : link.a], CLONE_NEWNET) != 0) return failed("setns");
  const int tun = ::open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (tun < 0) return failed("/dev/net/tun");
  ends_.push_back({tun});
  const std::string name = fmt::format("link{}", number);
  ifreq ask{};
  ask.ifr_flags = IFF_TUN | IFF_NO_PI;
  std::strncpy(ask.ifr_name, name.c_str(), IFNAMSIZ - 1);
  if (::ioctl(tun, TUNSETIFF, &ask) != 0) return failed("cannot make a TUN device");
  if (!configure(name, address_text(number, second), address_text(number, !second)))
    return failed("cannot configure " + name);
  return success();
}

EmulatedNet::~EmulatedNet() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
  for (const End& end : ends_) ::close(end.tun);
  for (const int net : namespaces_) ::close(net);
}

std::string EmulatedNet::address(std::size_t link, std::size_t of) const {
  return address_text(link, links_[link].b == of);
}

void EmulatedNet::in(std::size_t net, const std::function<void()>& body) const {
  std::thread([&] {
    if (::setns(namespaces_[net], CLONE_NEWNET) == 0) body();
  }).join();
}

pid_t EmulatedNet::start(std::size_t net, const std::vector<std::string>& command, int output) const {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child != 0) return child;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent || ::setns(namespaces_[net], CLONE_NEWNET) != 0) ::_exit(126);
  if (output >= 0) ::dup2(output, STDOUT_FILENO);
  ::execvp(arguments[0], arguments.data());
  ::_exit(127);
}

void EmulatedNet::set(std::size_t link, const LinkTraits& there, const LinkTraits& back) {
  const std::lock_guard lock(mutex_);
  models_[2 * link]->set(there);
  models_[2 * link + 1]->set(back);
}
void EmulatedNet::set_up(std::size_t link, bool up) {
  const std::lock_guard lock(mutex_);
  models_[2 * link]->set_up(up);
  models_[2 * link + 1]->set_up(up);
}
LinkCount EmulatedNet::count(std::size_t link, bool back) const {
  const std::lock_guard lock(mutex_);
  return models_[2 * link + (back ? 1 : 0)]->count();
}
void EmulatedNet::keep_queues(std::size_t link) {
  const std::lock_guard lock(mutex_);
  for (const std::size_t end : {2 * link, 2 * link + 1}) models_[end]->keep_queues(true);
}
std::vector<Duration> EmulatedNet::queues(std::size_t link, bool back) const {
  const std::lock_guard lock(mutex_);
  return models_[2 * link + (back ? 1 : 0)]->queues();
}

void EmulatedNet::run() {
  sched_param urgent{};
  urgent.sched_priority = 1;
  ::sched_setscheduler(0, SCHED_FIFO, &urgent);  // the link's clock must not wait for a busy machine; best effort
  std::vector<pollfd> polls;
  for (const End& end : ends_) polls.push_back({end.tun, POLLIN, 0});
  while (!stopping_) {
    Duration wait = kLongestWait;
    if (!late_.empty()) wait = std::clamp<Duration>(late_.front().at - now(), Duration::zero(), kLongestWait);
    const timespec timeout{0, wait.count()};
    ::ppoll(polls.data(), polls.size(), &timeout, nullptr);
    for (std::size_t i = 0; i < polls.size(); ++i)
      if (polls[i].revents != 0) receive(i);
    while (!late_.empty() && late_.front().at <= now()) {
      std::ranges::pop_heap(late_, Late::later);
      const Late& late = late_.back();
      [[maybe_unused]] const auto n = ::write(ends_[late.to].tun, late.bytes.data(), late.bytes.size());
      late_.pop_back();
    }
  }
}

void EmulatedNet::receive(std::size_t end) {
  std::array<std::uint8_t, 4096> packet;
  for (int i = 0; i < kPacketsAtOnce; ++i) {
    const ssize_t size = ::read(ends_[end].tun, packet.data(), packet.size());
    if (size <= 0) return;
    if (packet[0] >> 4 != 4) continue;  // the kernel's own IPv6 greetings
    LinkModel::Arrivals arrivals;
    {
      const std::lock_guard lock(mutex_);
      arrivals = models_[end]->pass(now(), static_cast<std::size_t>(size));
    }
    for (std::size_t k = 0; k < arrivals.count; ++k) {
      late_.push_back({arrivals.at[k], order_++, end ^ 1u, {packet.begin(), packet.begin() + size}});
      std::ranges::push_heap(late_, Late::later);
    }
  }
}

}  // namespace onemap::test
