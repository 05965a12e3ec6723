// How the radio is made: from the configuration, and from what is on the disk.
#include "comms/udp/silent_port.hpp"
#include "daemon/addresses.hpp"
#include "daemon/clock.hpp"
#include "daemon/identity_file.hpp"
#include "daemon/radio.hpp"
#include "mapping/records/keeping.hpp"

namespace onemap::daemon {

namespace {
Result<comms::NodeConfig> node_config(const Config& config) {
  comms::NodeConfig node;
  node.self = RobotId::from_name(config.id);
  node.keeping = [](std::uint16_t kind) {
    const auto k = static_cast<mapping::RecordKind>(kind);
    if (mapping::only_the_last_counts(k)) return comms::Keeping::until_the_next;
    return mapping::may_be_replaced(k) ? comms::Keeping::until_it_may_go : comms::Keeping::always;
  };
  node.bytes_per_second = config.bytes_per_second;
  node.memory_at_once = true;
  node.link_budget_bytes_per_second = config.link_bytes_per_second;
  node.link_budget_bytes_per_day = config.link_mb_per_day * 1'000'000;
  for (const std::string& peer : config.peers) {
    auto endpoint = comms::parse_endpoint(peer);
    if (!endpoint) return Error{"peer " + endpoint.error().place, endpoint.error().reason};
    node.peers.push_back(*endpoint);
  }
  return node;
}

Result<comms::UdpConfig> udp_config(const Config& config) {
  auto listen = comms::parse_endpoint(config.listen.empty() ? "0.0.0.0:0" : config.listen);
  if (!listen) return Error{"listen " + listen.error().place, listen.error().reason};
  comms::UdpConfig udp;
  udp.listen = *listen;
  if (config.group.empty()) return udp;
  const auto group = comms::parse_endpoint(config.group);
  if (!group) return Error{"group " + group.error().place, group.error().reason};
  udp.group = *group;
  return udp;
}

Result<std::unique_ptr<comms::DatagramPort>> open_port(const Config& config, comms::NodeConfig& node) {
  using Port = std::unique_ptr<comms::DatagramPort>;
  if (config.alone()) return Port(std::make_unique<comms::SilentPort>());
  auto udp = udp_config(config);
  if (!udp) return udp.error();
  node.group = udp->group;
  auto port = comms::UdpPort::open(*udp);
  if (!port) return port.error();
  return Port(std::move(*port));
}
}  // namespace

Result<std::unique_ptr<Radio>> Radio::open(const Config& config, Listener listener, Failures& failures, Log& log) {
  auto node = node_config(config);
  if (!node) return node.error();
  auto port = open_port(config, *node);
  if (!port) return port.error();
  LifeCounter life(config.out);
  if (auto begun = life.begin(wall_clock_ns()); !begun)
    log.warn(
        "{}; this life's number is the clock's: {}; make OUT writable, or neighbours may take this life for an old one",
        begun.error().text(), life.number());
  Store store = open_store(config, log);
  // Whatever became of the counter: no life whose records are here begins again.
  for (const auto& [own, count] : store.log->frontier())
    if (own.robot == node->self && own.incarnation >= life.number()) (void)life.begin_after(own.incarnation);
  node->incarnation = life.number();
  auto identity = open_identity(config.out + "/identity");
  if (!identity && config.alone())
    log.warn("{}; this robot is alone and signs with a key for this life only", identity.error().text());
  else if (!identity)
    return identity.error();
  node->identity = identity ? *identity : passing_identity();
  std::unique_ptr<TeamSeal> seal;
  if (!config.alone()) {
    auto opened = TeamSeal::open(config, *node->identity, log);
    if (!opened) return opened.error();
    seal = std::move(*opened);
    if (seal)
      log.line("{}", seal->words());
    else
      log.line("no team key: this robot talks to this machine only (`onemapctl team init` makes a key)");
  }
  node->sealed = seal != nullptr;
  return std::unique_ptr<Radio>(new Radio(config, std::move(store), std::move(*node), life, std::move(*port),
                                          std::move(seal), std::move(listener), failures, log));
}

// What cannot be kept on the disk is kept in memory, and people hear of it.
Radio::Store Radio::open_store(const Config& config, Log& log) {
  Store store;
  if (config.keep_log && !config.once) {
    auto disk = comms::PosixDisk::open(config.out + "/log");
    comms::DiskStoreConfig limits;
    limits.budget_bytes = config.store_budget_bytes;
    limits.author_bytes = config.alone() ? config.store_budget_bytes : config.store_budget_bytes / 4 * 3;
    auto opened =
        disk ? comms::DiskStore::open(**disk, limits) : Result<std::unique_ptr<comms::DiskStore>>(disk.error());
    if (opened) {
      store.disk = std::move(*disk);
      store.kept = opened->get();
      store.log = std::move(*opened);
      const auto view = store.kept->view();
      for (const std::string& message : view.messages) log.warn("{}/log: {}", config.out, message);
      if (view.records > 0)
        log.line("{} records of earlier lives and of the team are in {}/log", view.records, config.out);
      return store;
    }
    log.warn("the log is not kept on the disk: {}; after a restart this robot begins anew: make room, or OUT writable",
             opened.error().text());
  }
  store.log = std::make_unique<comms::MemoryStore>(config.store_budget_bytes);
  return store;
}

}  // namespace onemap::daemon
