// ENet: reliable packets, bulk on one channel and poses on another.
#include <enet/enet.h>

#include "peer.hpp"

namespace onemap::bench {

namespace {
constexpr std::uint16_t kPort = 7450;
constexpr std::size_t kAhead =
    128'000;  // bytes of bulk that wait in ENet's queue, twice its window: poses stand behind them

ENetAddress address_of(const std::string& text) {
  ENetAddress address;
  enet_address_set_host_ip(&address, text.c_str());
  address.port = kPort;
  return address;
}

int send(const Job& job) {
  ENetHost* host = enet_host_create(nullptr, 1, 2, 0, 0);
  const ENetAddress there = address_of(job.there);
  ENetPeer* peer = enet_host_connect(host, &there, 2, 0);
  PoseClock poses(job);
  bool connected = false;
  const std::vector<std::uint8_t> body(kBulkBytes, 7);
  while (true) {
    ENetEvent event;
    while (enet_host_service(host, &event, 1) > 0) {
      connected = event.type == ENET_EVENT_TYPE_CONNECT || (connected && event.type != ENET_EVENT_TYPE_DISCONNECT);
      if (event.type != ENET_EVENT_TYPE_DISCONNECT) continue;
      enet_peer_reset(peer);
      peer = enet_host_connect(host, &there, 2, 0);
    }
    if (!connected) continue;
    if (job.poses && poses.due()) {
      const auto pose = pose_now();
      enet_peer_send(peer, 0, enet_packet_create(pose.data(), pose.size(), ENET_PACKET_FLAG_RELIABLE));
    }
    while (enet_list_size(&peer->outgoingCommands) * 1392u < kAhead)
      if (enet_peer_send(peer, 1, enet_packet_create(body.data(), body.size(), ENET_PACKET_FLAG_RELIABLE)) < 0) break;
  }
}

int receive(const Job& job) {
  const ENetAddress here = address_of(job.here);
  ENetHost* host = enet_host_create(&here, 4, 2, 0, 0);
  if (host == nullptr) return 1;
  Tally tally(job.seconds);
  while (!tally.over()) {
    ENetEvent event;
    if (enet_host_service(host, &event, 2) <= 0 || event.type != ENET_EVENT_TYPE_RECEIVE) continue;
    if (event.channelID == 0)
      tally.pose({event.packet->data, event.packet->dataLength});
    else
      tally.bulk(event.packet->dataLength);
    enet_packet_destroy(event.packet);
  }
  tally.print(0.0);
  return 0;
}
}  // namespace

int run_enet(const Job& job) {
  if (enet_initialize() != 0) return 1;
  return job.sends ? send(job) : receive(job);
}

}  // namespace onemap::bench
