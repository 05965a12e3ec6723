#include "mock_port.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace onemap::test {

namespace {

constexpr std::uint8_t kIn = 0x80;
constexpr std::size_t kSetupBytes = 8;

void init_class(gpointer klass, gpointer) {
  static_cast<UMockdevIoctlBaseClass*>(klass)->handle_ioctl = MockPort::on_ioctl;
}

GType handler_type() {
  static const GType type =
      g_type_register_static_simple(umockdev_ioctl_base_get_type(), "OnemapMockPort", sizeof(UMockdevIoctlBaseClass),
                                    init_class, sizeof(UMockdevIoctlBase), nullptr, GTypeFlags{});
  return type;
}

std::uint8_t* buffer_of(const usbdevfs_urb& urb) { return static_cast<std::uint8_t*>(urb.buffer); }

Urb urb_of(const usbdevfs_urb& from, std::uint32_t number) {
  Urb urb;
  urb.number = number;
  urb.endpoint = from.endpoint & ~kIn;
  urb.in = (from.endpoint & kIn) != 0;
  urb.length = static_cast<std::uint32_t>(from.buffer_length);
  const std::uint8_t* data = buffer_of(from);
  if (from.type == USBDEVFS_URB_TYPE_CONTROL) {
    std::copy_n(data, kSetupBytes, urb.setup.begin());
    urb.in = (urb.setup[0] & kIn) != 0;
    urb.length -= kSetupBytes;
    data += kSetupBytes;
  }
  if (!urb.in) urb.out.assign(data, data + urb.length);
  std::uint32_t offset = 0;
  for (int i = 0; from.type == USBDEVFS_URB_TYPE_ISO && i < from.number_of_packets; ++i) {
    urb.packets.push_back({offset, from.iso_frame_desc[i].length});
    offset += from.iso_frame_desc[i].length;
  }
  return urb;
}

}  // namespace

MockPort::MockPort(UsbDevice& device, Speed speed, const std::string& node) : UsbPort(speed), device_(device) {
  unlink(node.c_str());
  if (mkfifo(node.c_str(), 0600) != 0) throw std::runtime_error("no pipe " + node);
  pipe_ = ::open(node.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  // One page, so that a byte in it fills it.
  if (pipe_ < 0 || fcntl(pipe_, F_SETPIPE_SZ, 4096) != 4096) throw std::runtime_error("no pipe " + node);
  device_.plug(*this);
  show_ready();
}

MockPort::~MockPort() {
  detach();
  close(pipe_);
}

void MockPort::attach(UMockdevTestbed* testbed, const std::string& path) {
  testbed_ = testbed;
  path_ = path;
  handler_ = static_cast<UMockdevIoctlBase*>(g_object_new(handler_type(), nullptr));
  g_object_set_data(reinterpret_cast<GObject*>(handler_), "port", this);
  if (!umockdev_testbed_attach_ioctl(testbed, path.c_str(), handler_, nullptr))
    throw std::runtime_error("umockdev does not take the handler of " + path);
}

void MockPort::detach() {
  if (!handler_) return;
  umockdev_testbed_detach_ioctl(testbed_, path_.c_str(), nullptr);
  g_object_unref(handler_);
  handler_ = nullptr;
}

gboolean MockPort::on_ioctl(UMockdevIoctlBase* base, UMockdevIoctlClient* client) {
  auto* port = static_cast<MockPort*>(g_object_get_data(reinterpret_cast<GObject*>(base), "port"));
  const unsigned long request = umockdev_ioctl_client_get_request(client) & 0xFFFFFFFFu;
  void* argument = nullptr;
  std::memcpy(&argument, umockdev_ioctl_client_get_arg(client)->data, sizeof argument);
  int code = 0;
  {
    const std::lock_guard lock(port->mutex_);
    code = port->call(client, request, argument);
    port->show_ready();
  }
  umockdev_ioctl_client_complete(client, code == 0 ? 0 : -1, code);
  return TRUE;
}

int MockPort::call(File file, unsigned long request, void* argument) {
  switch (request) {
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
      return reap(file, static_cast<void**>(argument));
    case USBDEVFS_GET_CAPABILITIES: {
      const std::uint32_t can =
          USBDEVFS_CAP_BULK_CONTINUATION | USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      std::memcpy(argument, &can, sizeof can);
      return 0;
    }
    default:
      break;
  }
  if (!present_) return ENODEV;
  switch (request) {
    case USBDEVFS_SUBMITURB:
      return submit({file, static_cast<usbdevfs_urb*>(argument)});
    case USBDEVFS_DISCARDURB:
      return discard(static_cast<usbdevfs_urb*>(argument));
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_RELEASEINTERFACE:
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_SETCONFIGURATION:
    case USBDEVFS_CLEAR_HALT:
    case USBDEVFS_RESET:
      return 0;
    case USBDEVFS_GETDRIVER:
      return ENODATA;
    default:
      return ENOTTY;
  }
}

int MockPort::submit(const Owned& owned) {
  if (until_pulled_out_ >= 0 && until_pulled_out_-- == 0) {
    vanish();
    return ENODEV;
  }
  const std::uint32_t number = ++last_number_;
  owned.urb->actual_length = 0;
  submitted_[number] = owned;
  device_.handle({.urb = urb_of(*owned.urb, number), .taken_back = 0, .number = number}, *this);
  device_.step(std::chrono::steady_clock::now(), *this);
  return 0;
}

int MockPort::discard(const usbdevfs_urb* urb) {
  const auto found = std::ranges::find(submitted_, urb, [](const auto& entry) { return entry.second.urb; });
  if (found == submitted_.end()) return EINVAL;
  device_.handle({.urb = {}, .taken_back = found->first, .number = ++last_number_}, *this);
  return 0;
}

int MockPort::reap(File file, void** into) {
  const auto found = std::ranges::find(done_, file, &Owned::file);
  if (found == done_.end()) return present_ ? EAGAIN : ENODEV;
  *into = found->urb;
  done_.erase(found);
  return 0;
}

void MockPort::step() {
  const std::lock_guard lock(mutex_);
  if (present_) device_.step(std::chrono::steady_clock::now(), *this);
  show_ready();
}

void MockPort::pull_out() {
  const std::lock_guard lock(mutex_);
  vanish();
  show_ready();
}

void MockPort::vanish() {
  present_ = false;
  while (!submitted_.empty()) complete(submitted_.begin()->first, -ESHUTDOWN, 0);
}

void MockPort::complete(std::uint32_t number, int status, int bytes) {
  const auto found = submitted_.find(number);
  if (found == submitted_.end()) return;
  found->second.urb->status = status;
  found->second.urb->actual_length = bytes;
  done_.push_back(found->second);
  submitted_.erase(found);
}

void MockPort::answer(const Urb& urb, std::span<const std::uint8_t> data) {
  const auto found = submitted_.find(urb.number);
  if (found == submitted_.end()) return;
  const usbdevfs_urb& into = *found->second.urb;
  const std::size_t bytes = urb.in ? std::min<std::size_t>(data.size(), urb.length) : urb.length;
  if (urb.in) std::copy_n(data.data(), bytes, buffer_of(into) + (urb.endpoint == 0 ? kSetupBytes : 0));
  complete(urb.number, 0, static_cast<int>(bytes));
}

void MockPort::answer_packets(const Urb& urb, std::span<const std::vector<std::uint8_t>> packets) {
  const auto found = submitted_.find(urb.number);
  if (found == submitted_.end()) return;
  usbdevfs_urb& into = *found->second.urb;
  into.error_count = 0;
  std::uint32_t all = 0;
  for (std::size_t i = 0; i < urb.packets.size(); ++i) {
    const std::size_t bytes = i < packets.size() ? std::min<std::size_t>(packets[i].size(), urb.packets[i].length) : 0;
    if (bytes > 0) std::copy_n(packets[i].data(), bytes, buffer_of(into) + urb.packets[i].offset);
    into.iso_frame_desc[i].actual_length = static_cast<unsigned>(bytes);
    into.iso_frame_desc[i].status = 0;
    all += static_cast<std::uint32_t>(bytes);
  }
  complete(urb.number, 0, static_cast<int>(all));
}

void MockPort::refuse(const Urb& urb) { complete(urb.number, -EPIPE, 0); }

void MockPort::give_back(const Request& request, bool) { complete(request.taken_back, -ENOENT, 0); }

void MockPort::show_ready() {
  const bool ready = !done_.empty();
  if (ready == ready_) return;
  char byte = 0;
  if ((ready ? read(pipe_, &byte, 1) : write(pipe_, &byte, 1)) == 1) ready_ = ready;
}

}  // namespace onemap::test
