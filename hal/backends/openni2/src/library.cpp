#include "library.hpp"

#include <dlfcn.h>
#include <link.h>

#include <algorithm>
#include <string_view>

#include "hal/base/text.hpp"

namespace onemap::hal::openni2 {

namespace {
// Loading and unloading are not safe beside each other.
std::mutex& loading() {
  static std::mutex mutex;
  return mutex;
}

int note_player(dl_phdr_info* object, std::size_t, void* into) {
  const std::string_view path = object->dlpi_name;
  if (path.find("libOniFile.so") != std::string_view::npos) *static_cast<std::string*>(into) = path;
  return 0;
}

// The library's driver that plays files cancels its thread when a file is closed, and does not wait for it. Were it
// unloaded then, the thread would unwind through code that is gone: it stays in memory for good.
void keep_player_loaded() {
  std::string player;
  dl_iterate_phdr(note_player, &player);
  if (!player.empty()) dlopen(player.c_str(), RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
}
}  // namespace

Error library_error(const std::string& place, const std::string& what) {
  std::string why = openni::OpenNI::getExtendedError();
  std::ranges::replace(why, '\n', ' ');
  constexpr const char* kBlank = " \t";  // it indents each message
  why.erase(0, why.find_first_not_of(kBlank));
  why.erase(why.find_last_not_of(kBlank) + 1);
  return {place, printable(why.empty() ? what : what + ": " + why)};
}

Result<std::shared_ptr<Library>> Library::load() {
  const std::lock_guard lock(loading());
  if (openni::OpenNI::initialize() != openni::STATUS_OK)
    return library_error("OpenNI2", "the library cannot start (are its drivers installed?)");
  keep_player_loaded();
  return std::shared_ptr<Library>(new Library);
}

Library::~Library() {
  const std::lock_guard lock(loading());
  openni::OpenNI::shutdown();
}

Result<std::unique_ptr<Hotplug>> Hotplug::listen() {
  std::unique_ptr<Hotplug> self(new Hotplug);
  OniDeviceCallbacks callbacks{};
  callbacks.deviceConnected = [](const OniDeviceInfo*, void* me) { static_cast<Hotplug*>(me)->note_arrival(); };
  callbacks.deviceDisconnected = [](const OniDeviceInfo* info, void* me) {
    static_cast<Hotplug*>(me)->note_departure(info->uri);
  };
  if (oniRegisterDeviceCallbacks(&callbacks, self.get(), &self->handle_) != ONI_STATUS_OK)
    return library_error("OpenNI2", "does not tell about devices that come and go");
  return self;
}

Hotplug::~Hotplug() {
  if (handle_) oniUnregisterDeviceCallbacks(handle_);
}

void Hotplug::watch(const std::string& uri) {
  const std::lock_guard lock(mutex_);
  uri_ = uri;
  left_ = false;
}

bool Hotplug::left() const {
  const std::lock_guard lock(mutex_);
  return left_;
}

bool Hotplug::wait_for_arrival(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  const bool arrived = changed_.wait_for(lock, timeout, [&] { return arrived_; });
  arrived_ = false;
  return arrived;
}

void Hotplug::note_arrival() {
  const std::lock_guard lock(mutex_);
  arrived_ = true;
  changed_.notify_all();
}

void Hotplug::note_departure(const std::string& uri) {
  const std::lock_guard lock(mutex_);
  left_ = left_ || uri == uri_;
}

std::vector<openni::DeviceInfo> connected_devices() {
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  std::vector<openni::DeviceInfo> out;
  out.reserve(static_cast<std::size_t>(devices.getSize()));
  for (int i = 0; i < devices.getSize(); ++i) out.push_back(devices[i]);
  return out;
}

}  // namespace onemap::hal::openni2
