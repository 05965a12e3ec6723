#include "notary.hpp"

namespace onemap::comms {

void Notary::start(const LogStore& store) {
  for (const auto& [log, count] : store.frontier()) {
    if (const auto first = store.find({log, 0})) pin(log.robot, first->seal.previous);
    if (const auto last = store.find({log, count - 1})) ends_[log] = hash_of(head_of(*last));
  }
}

Notary::Verdict Notary::look_at(const Record& record) const {
  const RecordHead head = head_of(record);
  const auto known = keys_.find(record.id.log.robot);
  const bool first = record.id.seq == 0;
  if (known == keys_.end() && !first) return {Refusal::bad_signature, {}};
  if (first && known != keys_.end() && known->second != head.previous) return {Refusal::second_key, {}};
  const PublicKey& key = known == keys_.end() ? head.previous : known->second;
  if (!signed_by(key, head, record.seal.signature)) return {Refusal::bad_signature, {}};
  if (!first && head.previous != end_of(record.id.log)) return {Refusal::forked, {}};
  return {Refusal::count, hash_of(head)};
}

bool Notary::vouches(const Record& record, const SignedHead& by) const {
  const auto known = keys_.find(record.id.log.robot);
  return signed_by(known == keys_.end() ? record.seal.previous : known->second, by.head, by.signature);
}

void Notary::took(const RecordId& id, const Hash& previous, const Hash& hash) {
  if (id.seq == 0) pin(id.log.robot, previous);
  ends_[id.log] = hash;
}

std::optional<PublicKey> Notary::key_of(const RobotId& robot) const {
  const auto at = keys_.find(robot);
  return at == keys_.end() ? std::nullopt : std::optional(at->second);
}

Hash Notary::end_of(const LogId& log) const {
  const auto at = ends_.find(log);
  return at == ends_.end() ? Hash{} : at->second;
}

}  // namespace onemap::comms
