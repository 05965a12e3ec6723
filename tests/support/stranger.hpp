#pragma once
// A peer on loopback that speaks the protocol and says whatever a test wants: greets a daemon, announces logs and
// serves their records. Written beside the product's Node, on its codec alone.
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "comms/frontier.hpp"
#include "comms/udp/udp_port.hpp"
#include "comms/wire.hpp"
#include "daemon/clock.hpp"
#include "support/patience.hpp"
#include "support/signed_logs.hpp"

namespace onemap::test {

inline RobotId raw_id(const std::string& bytes) {  // any bytes, valid or not
  RobotId id;
  std::copy_n(bytes.begin(), std::min(bytes.size(), id.bytes.size()), id.bytes.begin());
  return id;
}

class Stranger {
 public:
  Stranger(const std::string& id, std::uint16_t victim_port, std::uint64_t incarnation = 1'800'000'000'000'000'000u)
      : id_(raw_id(id)), incarnation_(incarnation), victim_(comms::Endpoint::ipv4(127, 0, 0, 1, victim_port)) {
    auto port = comms::UdpPort::open({comms::Endpoint::ipv4(127, 0, 0, 1, 0), {}});
    if (!port) throw std::runtime_error(port.error().text());
    port_ = std::move(*port);
  }

  // A record in anybody's name.
  void write(const RobotId& robot, std::uint64_t incarnation, std::uint8_t lane, std::uint16_t kind,
             std::vector<std::uint8_t> body) {
    const LogId log{robot, lane, incarnation};
    logs_[log].push_back(signed_.next(log, kind, std::move(body)));
  }
  void write(std::uint8_t lane, std::uint16_t kind, std::vector<std::uint8_t> body) {
    write(id_, incarnation_, lane, kind, std::move(body));
  }

  // Greets until it is answered, then announces and serves for the given time, or until `done`.
  void talk(
      std::chrono::milliseconds time, const std::function<bool()>& done = [] { return false; }) {
    const Instant end = daemon::now() + kPatience * time;
    Instant next{};
    while (daemon::now() < end && !done()) {
      if (daemon::now() >= next) {
        announce();
        next = daemon::now() + std::chrono::milliseconds(250);
      }
      port_->wait(std::chrono::milliseconds(20));
      comms::IncomingDatagram datagram;
      while (port_->receive(datagram)) answer(datagram);
    }
  }
  void say(const std::function<void(comms::wire::Encoder&)>& frames) {
    comms::OutgoingDatagram out;
    out.to = victim_;
    comms::wire::Encoder encoder(out.buffer,
                                 {comms::wire::DatagramType::unicast, incarnation_, victim_incarnation_, ++counter_});
    frames(encoder);
    out.size = encoder.size();
    port_->send(out);
  }

  const RobotId& id() const { return id_; }
  std::uint64_t incarnation() const { return incarnation_; }
  bool answered() const { return victim_incarnation_ != 0; }
  std::uint64_t victim_incarnation() const { return victim_incarnation_; }
  std::size_t served() const { return served_; }  // fragments

 private:
  void announce() {
    VersionVector frontier;
    std::vector<comms::wire::HaveEntry> entries;
    for (const auto& [log, records] : logs_) {
      frontier[log] = static_cast<std::uint32_t>(records.size());
      entries.push_back({log, frontier[log]});
    }
    const std::uint64_t digest = comms::digest(frontier);
    say([&](auto& out) { out.beacon({id_, digest, 0, ++status_, 1}); });
    if (!answered()) return;
    for (std::size_t at = 0; at < entries.size(); at += 30)
      say([&](auto& out) {
        out.have(digest, std::span(entries).subspan(at, std::min<std::size_t>(30, entries.size() - at)));
      });
  }
  void answer(const comms::IncomingDatagram& datagram) {
    if (decoder_.decode(datagram.bytes()) != comms::Refusal::count) return;
    victim_incarnation_ = decoder_.header().sender;
    for (const auto& frame : decoder_.frames()) {
      if (const auto* ping = std::get_if<comms::wire::Ping>(&frame)) say([&](auto& out) { out.pong(ping->token); });
      if (const auto* want = std::get_if<comms::wire::Want>(&frame))
        for (const auto& entry : want->entries) serve(entry);
    }
  }
  void serve(const comms::wire::WantEntry& entry) {
    const auto log = logs_.find(entry.id.log);
    if (log == logs_.end() || entry.id.seq >= log->second.size()) return;
    const Record& record = log->second[entry.id.seq];
    const std::uint32_t fragments = comms::wire::fragments_of(comms::wire::payload_bytes(record));
    for (std::uint32_t f = entry.first; f < std::min<std::uint32_t>(fragments, entry.first + entry.count); ++f) {
      comms::wire::FragmentBuffer scratch;
      const comms::wire::Data data = comms::sim::fragment(record, f, scratch);
      say([&](auto& out) { out.data(data); });
      ++served_;
    }
  }

  const RobotId id_;
  const std::uint64_t incarnation_;
  const comms::Endpoint victim_;
  std::unique_ptr<comms::UdpPort> port_;
  comms::sim::SignedLogs signed_;
  std::map<LogId, std::vector<Record>> logs_;
  comms::wire::Decoder decoder_;
  std::uint64_t victim_incarnation_ = 0;
  std::uint32_t counter_ = 0, status_ = 0;
  std::size_t served_ = 0;
};

}  // namespace onemap::test
