// NORM (RFC 5740) with its congestion control, unicast: a stream of bulk. Its sender has one queue, so poses are left
// out.
#include <normApi.h>
#include <sys/select.h>

#include "peer.hpp"

namespace onemap::bench {

namespace {
constexpr std::uint16_t kPort = 7451;
constexpr unsigned kStreamBytes = 4 << 20, kSegmentBytes = 1400, kBlock = 64, kParity = 16;

int send(NormInstanceHandle instance, NormSessionHandle session) {
  NormSetGrttEstimate(session, 0.02);
  NormSetCongestionControl(session, true);
  NormSetTxSocketBuffer(session, 1 << 20);
  if (!NormStartSender(session, 1, 8 << 20, kSegmentBytes, kBlock, kParity)) return 1;
  const NormObjectHandle stream = NormStreamOpen(session, kStreamBytes);
  const std::vector<char> body(kBulkBytes, 7);
  while (true) {
    while (NormStreamWrite(stream, body.data(), static_cast<unsigned>(body.size())) > 0) {
    }
    NormEvent event;
    NormGetNextEvent(instance, &event);  // waits for room, among others
  }
}

int receive(const Job& job, NormInstanceHandle instance, NormSessionHandle session) {
  NormSetDefaultUnicastNack(session, true);
  NormSetRxSocketBuffer(session, 4 << 20);
  if (!NormStartReceiver(session, 8 << 20)) return 1;
  Tally tally(job.seconds);
  const int descriptor = NormGetDescriptor(instance);
  std::vector<char> buffer(1 << 16);
  while (!tally.over()) {
    fd_set set;
    FD_ZERO(&set);
    FD_SET(descriptor, &set);
    timeval wait{0, 20'000};
    if (select(descriptor + 1, &set, nullptr, nullptr, &wait) <= 0) continue;
    NormEvent event;
    if (!NormGetNextEvent(instance, &event, false) || event.type != NORM_RX_OBJECT_UPDATED) continue;
    for (unsigned n = static_cast<unsigned>(buffer.size()); NormStreamRead(event.object, buffer.data(), &n) && n > 0;
         n = static_cast<unsigned>(buffer.size()))
      tally.bulk(n);
  }
  tally.print(0.0);
  return 0;
}
}  // namespace

int run_norm(const Job& job) {
  const NormInstanceHandle instance = NormCreateInstance();
  const NormSessionHandle session = NormCreateSession(instance, job.there.c_str(), kPort, job.sends ? 1 : 2);
  NormSetTxPort(session, kPort);
  return job.sends ? send(instance, session) : receive(job, instance, session);
}

}  // namespace onemap::bench
