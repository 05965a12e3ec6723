#include "usb_port.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <utility>

namespace onemap::test {

namespace {

constexpr const char* kAttach = "/sys/devices/platform/vhci_hcd.0/attach";
constexpr int kSuperPorts = 8;  // the controller's first port of USB 3
constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kAnswered = 3, kUnlinked = 4;
constexpr std::uint32_t kMostPackets = 1024;

// Big endian on the wire.
struct Header {
  std::uint32_t command, number, device, in, endpoint;
  std::uint32_t words[5];
  std::uint8_t setup[8];
};
static_assert(sizeof(Header) == 48);
struct PacketHeader {
  std::uint32_t offset, length, actual, status;
};

}  // namespace

void VhciPort::plug() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) throw std::runtime_error("socketpair");
  socket_ = ends[0];
  const int port = speed() == Speed::super ? kSuperPorts + number_ : number_;
  // The port may still be busy with saying goodbye to what was there.
  for (int tries = 0;; ++tries) {
    std::ofstream attach(kAttach);
    attach << fmt::format("{} {} {} {}", port, ends[1], 1 + number_, static_cast<int>(speed())) << std::flush;
    if (attach.good()) break;
    if (tries == 100) throw std::runtime_error(std::string(kAttach) + " refuses");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  close(ends[1]);  // the kernel keeps it
}

void VhciPort::unplug() {
  if (socket_ < 0) return;
  shutdown(socket_, SHUT_RDWR);
  close(std::exchange(socket_, -1));
}

bool VhciPort::read_all(void* into, std::size_t bytes) {
  auto* to = static_cast<std::uint8_t*>(into);
  while (bytes > 0) {
    const ssize_t got = read(socket_, to, bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

void VhciPort::write_all(const void* from, std::size_t bytes) {
  const auto* of = static_cast<const std::uint8_t*>(from);
  while (bytes > 0) {
    const ssize_t put = send(socket_, of, bytes, MSG_NOSIGNAL);
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return;  // it is being unplugged
    of += put;
    bytes -= static_cast<std::size_t>(put);
  }
}

std::optional<VhciPort::Request> VhciPort::wait(int timeout_ms) {
  pollfd file{socket_, POLLIN, 0};
  if (poll(&file, 1, timeout_ms) <= 0) return std::nullopt;
  Header header{};
  if (!read_all(&header, sizeof header)) {
    unplug();
    return std::nullopt;
  }
  Request request;
  request.number = ntohl(header.number);
  if (ntohl(header.command) == kUnlink) {
    request.taken_back = ntohl(header.words[0]);
    return request;
  }
  if (ntohl(header.command) != kSubmit) throw std::runtime_error("vhci sends an unknown command");
  Urb& urb = request.urb.emplace();
  urb.number = request.number;
  urb.endpoint = static_cast<int>(ntohl(header.endpoint));
  urb.in = ntohl(header.in) != 0;
  urb.length = ntohl(header.words[1]);
  std::memcpy(urb.setup.data(), header.setup, sizeof header.setup);
  if (!urb.in) {
    urb.out.resize(urb.length);
    if (!read_all(urb.out.data(), urb.out.size())) return std::nullopt;
  }
  const std::uint32_t packets = ntohl(header.words[3]);
  for (std::uint32_t i = 0; packets <= kMostPackets && i < packets; ++i) {
    PacketHeader packet{};
    if (!read_all(&packet, sizeof packet)) return std::nullopt;
    urb.packets.push_back({ntohl(packet.offset), ntohl(packet.length)});
  }
  return request;
}

void VhciPort::answer_header(const Urb& urb, std::int32_t status, std::uint32_t bytes) {
  Header header{};
  header.command = htonl(kAnswered);
  header.number = htonl(urb.number);
  header.words[0] = htonl(static_cast<std::uint32_t>(status));
  header.words[1] = htonl(bytes);
  header.words[3] = htonl(static_cast<std::uint32_t>(urb.packets.size()));
  write_all(&header, sizeof header);
}

void VhciPort::answer(const Urb& urb, std::span<const std::uint8_t> data) {
  const std::size_t bytes = urb.in ? std::min<std::size_t>(data.size(), urb.length) : urb.length;
  answer_header(urb, 0, static_cast<std::uint32_t>(bytes));
  if (urb.in) write_all(data.data(), bytes);
}

// The data of all packets without what they lack, then the packets' headers.
void VhciPort::answer_packets(const Urb& urb, std::span<const std::vector<std::uint8_t>> packets) {
  std::vector<std::uint8_t> data;
  std::vector<PacketHeader> headers;
  for (std::size_t i = 0; i < urb.packets.size(); ++i) {
    const std::size_t bytes = i < packets.size() ? std::min<std::size_t>(packets[i].size(), urb.packets[i].length) : 0;
    if (bytes > 0) data.insert(data.end(), packets[i].begin(), packets[i].begin() + static_cast<std::ptrdiff_t>(bytes));
    headers.push_back(
        {htonl(urb.packets[i].offset), htonl(urb.packets[i].length), htonl(static_cast<std::uint32_t>(bytes)), 0});
  }
  answer_header(urb, 0, static_cast<std::uint32_t>(data.size()));
  write_all(data.data(), data.size());
  write_all(headers.data(), headers.size() * sizeof(PacketHeader));
}

void VhciPort::refuse(const Urb& urb) { answer_header(urb, -EPIPE, 0); }

void VhciPort::give_back(const Request& request, bool was_waiting) {
  Header header{};
  header.command = htonl(kUnlinked);
  header.number = htonl(request.number);
  header.words[0] = htonl(static_cast<std::uint32_t>(was_waiting ? -ECONNRESET : 0));
  write_all(&header, sizeof header);
}

}  // namespace onemap::test
