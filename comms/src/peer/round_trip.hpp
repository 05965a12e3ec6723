#pragma once
#include "hal/base/time.hpp"

namespace onemap::comms {

// Smoothed round trip and the silence after which an answer is given up (RFC 6298, with a floor fit for one hop).
class RoundTrip {
 public:
  static constexpr unsigned kPatientSilences = 4;  // silences that do not lengthen the wait
  void sample(Duration rtt);
  Duration smoothed() const { return srtt_; }  // 0: not measured
  Duration give_up_after(unsigned silences) const;
  Duration reorder_window() const;  // how long an overtaken datagram may still be on its way
  void was_hasty();                 // what had been given up came after all

 private:
  Duration srtt_{0}, var_{0}, hasty_{0};
};

}  // namespace onemap::comms
