#include "session/session.hpp"

namespace onemap::comms {

Refusal Session::accept(const wire::Header& header, Arrival& arrival) {
  arrival.unicast = header.type == wire::DatagramType::unicast;
  const auto [verdict, at] = (arrival.unicast ? unicast_ : group_).accept(header.counter);
  arrival.at = at;
  switch (verdict) {
    case ReceiveWindow::Verdict::fresh:
      break;
    case ReceiveWindow::Verdict::duplicate:
      return Refusal::duplicate;
    case ReceiveWindow::Verdict::too_old:
      return Refusal::too_old;
    case ReceiveWindow::Verdict::jump:
      return Refusal::counter_jump;
  }
  return Refusal::count;
}

}  // namespace onemap::comms
