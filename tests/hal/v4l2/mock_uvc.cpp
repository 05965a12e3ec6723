#include "mock_uvc.hpp"

#include <fmt/format.h>
#include <umockdev.h>
#include <unistd.h>

#include <stdexcept>
#include <utility>

#include "mock_node.hpp"
#include "support/umockdev.hpp"

namespace onemap::test {

namespace {

void check(GError* error) {
  if (!error) return;
  const std::string text = error->message;
  g_error_free(error);
  throw std::runtime_error("umockdev: " + text);
}

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> one_size() { return {{640, 480}}; }

MockTestbed::MockTestbed() : testbed_(umockdev_testbed_new()) {}
MockTestbed::~MockTestbed() { g_object_unref(testbed_); }

bool MockTestbed::wrapped() { return inside_umockdev(); }

std::string MockTestbed::root() const {
  gchar* text = umockdev_testbed_get_root_dir(testbed_);
  std::string root = text;
  g_free(text);
  return root;
}

MockUvc::MockUvc(MockTestbed& testbed, int port, std::string usb_id, std::string product, MockNodeConfig depth,
                 MockNodeConfig colour)
    : testbed_(testbed),
      port_(port),
      usb_id_(std::move(usb_id)),
      product_(std::move(product)),
      depth_(std::make_unique<MockNode>(*this, std::move(depth))),
      colour_(std::make_unique<MockNode>(*this, std::move(colour))) {}

MockUvc::~MockUvc() {
  if (present_) unplug();
}

void MockUvc::on_bus(const std::string& speed, const std::string& version) {
  speed_ = speed;
  version_ = version;
}

void MockUvc::plug(int first_number) {
  const std::string usb = fmt::format("/devices/usb1/1-{}", port_);
  std::string text = fmt::format(
      "P: {}\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\nA: idVendor={}\\n\nA: idProduct={}\\n\nA: product={}\\n\n"
      "A: serial=S{}\\n\nA: speed={}\\n\n{}\n",
      usb, usb_id_.substr(0, 4), usb_id_.substr(5), product_, port_, speed_,
      version_.empty() ? "" : "A: version=" + version_ + "\\n\n");
  for (int i = 0; i < 2; ++i)
    text += fmt::format(
        "P: {0}/1-{1}:1.{2}/video4linux/video{3}\nN: video{3}\nE: DEVNAME=/dev/video{3}\nE: SUBSYSTEM=video4linux\n"
        "E: MAJOR=81\nE: MINOR={3}\nA: name={4}\\n\nA: index=0\\n\nA: dev=81:{3}\n\n",
        usb, port_, 3 * i, first_number + i, product_);
  GError* error = nullptr;
  umockdev_testbed_add_from_string(testbed_.handle(), text.c_str(), &error);
  check(error);
  depth_path_ = fmt::format("/dev/video{}", first_number);
  colour_path_ = fmt::format("/dev/video{}", first_number + 1);
  depth_->attach(depth_path_, testbed_.root() + depth_path_);
  colour_->attach(colour_path_, testbed_.root() + colour_path_);
  const std::lock_guard lock(mutex_);
  present_ = true;
  until_vanished_ = -1;
  now_us_ += 1'000'000;  // it takes a person a while
}

void MockUvc::unplug() {
  {
    const std::lock_guard lock(mutex_);
    present_ = false;
    paused_ = false;
  }
  const std::string usb = fmt::format("/sys/devices/usb1/1-{}", port_);
  int interface = 0;
  for (const auto& [node, path] : {std::pair(depth_.get(), depth_path_), std::pair(colour_.get(), colour_path_)}) {
    const std::string place =
        fmt::format("{}/1-{}:1.{}/video4linux/{}", usb, port_, std::exchange(interface, 3), path.substr(5));
    node->detach();
    umockdev_testbed_remove_device(testbed_.handle(), place.c_str());
    unlink((testbed_.root() + path).c_str());
  }
  umockdev_testbed_remove_device(testbed_.handle(), usb.c_str());
}

void MockUvc::pause(bool paused) {
  const std::lock_guard lock(mutex_);
  paused_ = paused;
}

void MockUvc::pass(std::int64_t microseconds) {
  const std::lock_guard lock(mutex_);
  now_us_ += microseconds;
}

void MockUvc::damage_next() {
  const std::lock_guard lock(mutex_);
  colour_->damage_next = true;
}

void MockUvc::refuse(unsigned long request, int code) {
  const std::lock_guard lock(mutex_);
  colour_->refused_request = request;
  colour_->refused_code = code;
}

void MockUvc::refuse_always(unsigned long request, int code) {
  refuse(request, code);
  const std::lock_guard lock(mutex_);
  colour_->refuses_always = true;
}

void MockUvc::vanish_at(int call) {
  const std::lock_guard lock(mutex_);
  until_vanished_ = call;
}

void MockUvc::hang() {
  const std::lock_guard lock(mutex_);
  depth_->hangs = colour_->hangs = true;
}

std::uint64_t MockUvc::open_buffers() const {
  const std::lock_guard lock(mutex_);
  return depth_->queued();
}

bool MockUvc::streaming() const {
  const std::lock_guard lock(mutex_);
  return depth_->streaming() && colour_->streaming();
}

bool MockUvc::streaming_colour() const {
  const std::lock_guard lock(mutex_);
  return colour_->streaming();
}

}  // namespace onemap::test
