#include "comms/udp/udp_port.hpp"

#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "socket_address.hpp"

namespace onemap::comms {

namespace {
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }
  bool valid() const { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

Error failed(const Endpoint& endpoint, std::string_view what) {
  return {to_string(endpoint), fmt::format("{}: {}", what, std::strerror(errno))};
}

template <class T>
bool set(int fd, int level, int option, const T& value) {
  return ::setsockopt(fd, level, option, &value, sizeof value) == 0;
}
}  // namespace

struct UdpPort::Impl {
  static constexpr std::size_t kBatch = 16;
  Endpoint local;
  int family = AF_INET;
  Descriptor socket, group, wakeup;
  UdpCounters counters;
  std::vector<IncomingDatagram> batch{kBatch};  // read ahead with one system call
  std::size_t next = 0, filled = 0;
  bool group_first = false;
  std::optional<Endpoint> group_at;
  ip_mreq membership{};

  Status open_socket(const UdpConfig& config);
  Status open_group(const Endpoint& listen, const Endpoint& endpoint);
  bool join();
  bool fill(int fd);
  bool fill_fairly();
};

Status UdpPort::Impl::open_socket(const UdpConfig& config) {
  family = config.listen.is_ipv4() ? AF_INET : AF_INET6;
  socket = Descriptor(::socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket.valid()) return failed(config.listen, "cannot make a UDP socket");
  set(socket.get(), SOL_SOCKET, SO_RCVBUF, config.receive_buffer_bytes);  // the kernel's limit is good enough
  if (family == AF_INET6) set(socket.get(), IPPROTO_IPV6, IPV6_V6ONLY, int{0});
  const SocketAddress address = SocketAddress::of(config.listen, family);
  if (::bind(socket.get(), address.raw(), address.size) != 0) return failed(config.listen, "cannot listen");
  SocketAddress bound;
  if (::getsockname(socket.get(), bound.raw(), &bound.size) != 0)
    return failed(config.listen, "cannot ask for the port");
  local = bound.endpoint();
  wakeup = Descriptor(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!wakeup.valid()) return failed(config.listen, "cannot make an event descriptor");
  return success();
}

// On the interface that the routes name now; being there already is good, too.
bool UdpPort::Impl::join() {
  return set(group.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, membership) || errno == EADDRINUSE;
}

// A socket bound to a unicast address does not hear the group: a second one listens for it; everything is sent from the
// first, so that the group learns our unicast port. Without a network (ENODEV) it is joined later, see send().
Status UdpPort::Impl::open_group(const Endpoint& listen, const Endpoint& endpoint) {
  if (!endpoint.is_ipv4() || !listen.is_ipv4()) return Error{to_string(endpoint), "multicast works over IPv4 only"};
  if ((endpoint.address[12] & 0xF0u) != 0xE0u)
    return Error{to_string(endpoint), "not a multicast address (224.0.0.0 to 239.255.255.255)"};
  group = Descriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!group.valid()) return failed(endpoint, "cannot make a UDP socket");
  set(group.get(), SOL_SOCKET, SO_REUSEADDR, int{1});  // several robots on one machine share the group's port
  const SocketAddress address = SocketAddress::of(endpoint, AF_INET);
  if (::bind(group.get(), address.raw(), address.size) != 0) return failed(endpoint, "cannot listen to the group");
  std::memcpy(&membership.imr_multiaddr, endpoint.address.data() + 12, 4);
  std::memcpy(&membership.imr_interface, listen.address.data() + 12, 4);
  if (!join() && errno != ENODEV) return failed(endpoint, "cannot join the group");
  if (!set(socket.get(), IPPROTO_IP, IP_MULTICAST_IF, membership.imr_interface))
    return failed(endpoint, "cannot send to the group from this address");
  set(socket.get(), IPPROTO_IP, IP_MULTICAST_TTL, int{1});
  set(socket.get(), IPPROTO_IP, IP_MULTICAST_LOOP, int{1});
  group_at = endpoint;
  return success();
}

bool UdpPort::Impl::fill(int fd) {
  std::array<mmsghdr, kBatch> headers{};
  std::array<iovec, kBatch> parts{};
  std::array<SocketAddress, kBatch> from{};
  for (std::size_t i = 0; i < kBatch; ++i) {
    parts[i] = {batch[i].buffer.data(), batch[i].buffer.size()};
    headers[i].msg_hdr.msg_iov = &parts[i];
    headers[i].msg_hdr.msg_iovlen = 1;
    headers[i].msg_hdr.msg_name = &from[i].storage;
    headers[i].msg_hdr.msg_namelen = from[i].size;
  }
  const int n = ::recvmmsg(fd, headers.data(), kBatch, 0, nullptr);
  if (n <= 0) {
    if (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) ++counters.receive_failed;
    return false;
  }
  next = 0;
  filled = static_cast<std::size_t>(n);
  for (std::size_t i = 0; i < filled; ++i) {
    batch[i].size = headers[i].msg_len;
    batch[i].from = from[i].endpoint();
  }
  counters.received += filled;
  return true;
}

// In turns, so that a flood to one socket does not silence the other.
bool UdpPort::Impl::fill_fairly() {
  next = filled = 0;
  if (!group.valid()) return fill(socket.get());
  group_first = !group_first;
  return fill((group_first ? group : socket).get()) || fill((group_first ? socket : group).get());
}

Result<std::unique_ptr<UdpPort>> UdpPort::open(const UdpConfig& config) {
  auto impl = std::make_unique<Impl>();
  if (Status opened = impl->open_socket(config); !opened) return opened.error();
  if (config.group) {
    if (Status joined = impl->open_group(config.listen, *config.group); !joined) return joined.error();
  }
  return std::unique_ptr<UdpPort>(new UdpPort(std::move(impl)));
}

UdpPort::UdpPort(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
UdpPort::~UdpPort() = default;

Endpoint UdpPort::local() const { return impl_->local; }
int UdpPort::descriptor() const { return impl_->socket.get(); }
const UdpCounters& UdpPort::counters() const { return impl_->counters; }

bool UdpPort::send(const OutgoingDatagram& datagram) {
  if (impl_->family == AF_INET && !datagram.to.is_ipv4()) return ++impl_->counters.send_failed, false;
  // A network that came, or came back, after the last greeting.
  if (impl_->group_at == datagram.to) impl_->join();
  const SocketAddress to = SocketAddress::of(datagram.to, impl_->family);
  const auto n = ::sendto(impl_->socket.get(), datagram.buffer.data(), datagram.size, 0, to.raw(), to.size);
  if (n == static_cast<ssize_t>(datagram.size)) return ++impl_->counters.sent, true;
  const bool blocked = n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS);
  ++(blocked ? impl_->counters.send_blocked : impl_->counters.send_failed);
  return false;
}

bool UdpPort::receive(IncomingDatagram& datagram) {
  if (impl_->next == impl_->filled && !impl_->fill_fairly()) return false;
  datagram = impl_->batch[impl_->next++];
  return true;
}

bool UdpPort::wait(Duration at_most) {
  if (impl_->next != impl_->filled) return true;
  std::array<pollfd, 3> descriptors{{{impl_->socket.get(), POLLIN, 0},
                                     {impl_->wakeup.get(), POLLIN, 0},
                                     {impl_->group.get(), POLLIN, 0}}};  // poll ignores -1
  const auto ns = std::max<std::int64_t>(at_most.count(), 0);
  const timespec timeout{ns / 1'000'000'000, ns % 1'000'000'000};
  if (::ppoll(descriptors.data(), descriptors.size(), &timeout, nullptr) <= 0) return false;
  if (descriptors[1].revents != 0) {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto n = ::read(impl_->wakeup.get(), &count, sizeof count);
  }
  return descriptors[0].revents != 0 || descriptors[2].revents != 0;
}

void UdpPort::wake() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto n = ::write(impl_->wakeup.get(), &one, sizeof one);
}

}  // namespace onemap::comms
