#pragma once
// Signed records of any robot, for tests: each has the key that follows from its name.
#include <algorithm>
#include <map>
#include <vector>

#include "comms/identity.hpp"
#include "comms/record_head.hpp"
#include "comms/wire/payload.hpp"

namespace onemap::comms::sim {

inline Identity identity_of(const RobotId& robot) {
  SecretSeed seed{};
  std::copy(robot.bytes.begin(), robot.bytes.end(), seed.begin());
  return Identity(seed);
}

// Writes logs in anybody's name, each record in its place of the chain. A place that was skipped is filled with a
// record of the same kind and body.
class SignedLogs {
 public:
  Record record(const RecordId& id, std::uint16_t kind, std::vector<std::uint8_t> body,
                std::uint32_t replaces = kNoSequence) {
    std::vector<Hash>& chain = chains_[id.log];
    Record out{id, kind, std::move(body), {}, {}};
    out.seal.replaces = replaces;
    while (chain.size() <= id.seq) {
      out.id.seq = static_cast<std::uint32_t>(chain.size());
      chain.push_back(seal(out, chain.empty() ? Hash{} : chain.back(), identity_of(id.log.robot)));
    }
    out.id = id;
    seal(out, id.seq == 0 ? Hash{} : chain[id.seq - 1], identity_of(id.log.robot));
    return out;
  }
  Record next(const LogId& log, std::uint16_t kind, std::vector<std::uint8_t> body,
              std::uint32_t replaces = kNoSequence) {
    return record({log, static_cast<std::uint32_t>(chains_[log].size())}, kind, std::move(body), replaces);
  }

 private:
  std::map<LogId, std::vector<Hash>> chains_;
};

// One fragment of a record; its bytes are in `scratch` or in the record.
inline wire::Data fragment(const Record& record, std::uint32_t index, wire::FragmentBuffer& scratch) {
  wire::Data data;
  data.id = record.id;
  data.kind = record.kind;
  data.total_bytes = wire::payload_bytes(record);
  data.body_hash = wire::payload_hash(record);
  data.fragment = static_cast<std::uint16_t>(index);
  data.bytes = wire::fragment_of(record, index, scratch);
  return data;
}

}  // namespace onemap::comms::sim
