#include "fuzz/targets.hpp"

namespace onemap::fuzz {

const std::vector<Target>& targets() {
  static const std::vector<Target> all{{"datagram", datagram},   {"frame", frame},   {"node", node},
                                       {"record", record},       {"config", config}, {"control", control},
                                       {"saved_map", saved_map}, {"image", image}};
  return all;
}

}  // namespace onemap::fuzz
