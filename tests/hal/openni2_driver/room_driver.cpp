// An OpenNI2 driver whose devices are simulated rooms and whose USB sockets are files: see device_file.hpp.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "room_device.hpp"

namespace onemap::test {

namespace {

struct Socket {
  OniDeviceInfo info{};  // the library knows a device by this address
  DeviceFile file;
  std::shared_ptr<RoomFeed> feed;
  bool plugged = false;
  RoomDevice* open = nullptr;
};

class RoomDriver final : public oni::driver::DriverBase {
 public:
  using DriverBase::DriverBase;

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    const char* folder = std::getenv("ONEMAP_TEST_DEVICES");
    if (!folder) return ONI_STATUS_OK;
    folder_ = folder;
    look(true);
    thread_ = std::thread([this] {
      for (; !over_; std::this_thread::sleep_for(std::chrono::milliseconds(5))) look(false);
    });
    return ONI_STATUS_OK;
  }

  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    const std::lock_guard lock(mutex_);
    for (auto& [name, socket] : sockets_) {
      if (name_of(uri) != name || !socket.plugged || socket.open) continue;
      if (!socket.feed) socket.feed = std::make_shared<RoomFeed>(socket.file);  // a room takes a while to paint
      socket.open = new RoomDevice(socket.file, socket.feed, folder_ / name);
      return socket.open;
    }
    return nullptr;
  }

  void deviceClose(oni::driver::DeviceBase* device) override {
    {
      const std::lock_guard lock(mutex_);
      for (auto& [name, socket] : sockets_)
        if (socket.open == device) socket.open = nullptr;
    }
    delete device;
  }

  void shutdown() override {
    over_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  static std::string name_of(const std::string& uri) { return uri.substr(uri.rfind('/') + 1); }

  Socket& named(const std::string& name) {
    const std::lock_guard lock(mutex_);
    return sockets_[name];
  }

  void look(bool first) {
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(folder_, none)) {
      if (entry.path().extension() != ".device") continue;
      Socket& socket = named(entry.path().stem().string());
      if (!socket.plugged) plug_in(socket, entry.path(), first);
    }
    for (auto& [name, socket] : sockets_)
      if (socket.plugged && !std::filesystem::exists(folder_ / (name + ".device"))) pull_out(socket);
  }

  void plug_in(Socket& socket, const std::filesystem::path& file, bool first) {
    try {
      const std::lock_guard lock(mutex_);
      socket.file = read_device_file(file);
      if (socket.file.unheard && !first) return;
      fmt::format_to_n(socket.info.uri, ONI_MAX_STR - 1, "room://{}", file.stem().string());
      fmt::format_to_n(socket.info.vendor, ONI_MAX_STR - 1, "onemap");
      fmt::format_to_n(socket.info.name, ONI_MAX_STR - 1, "Simulated room");
      socket.info.usbVendorId = 0x1d27;
      socket.info.usbProductId = 0x0601;
      socket.plugged = true;
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}\n", error.what());
      std::abort();
    }
    deviceConnected(&socket.info);
  }

  void pull_out(Socket& socket) {
    {
      const std::lock_guard lock(mutex_);
      socket.plugged = false;
      if (socket.open) socket.open->pull_out();
    }
    deviceDisconnected(&socket.info);
  }

  std::filesystem::path folder_;
  std::mutex mutex_;
  std::map<std::string, Socket> sockets_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

}  // namespace

}  // namespace onemap::test

ONI_EXPORT_DRIVER(onemap::test::RoomDriver)
