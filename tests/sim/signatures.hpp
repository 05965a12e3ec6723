#pragma once

namespace onemap::comms::sim {

// As long as one of these lives, a signature is computed once in this thread, and not by each simulated robot that
// looks at it: what it says of the same bytes is always the same, and a team of a hundred would do nothing else.
struct RememberSignatures {
  RememberSignatures();
  ~RememberSignatures();
  RememberSignatures(const RememberSignatures&) = delete;
  RememberSignatures& operator=(const RememberSignatures&) = delete;
};

}  // namespace onemap::comms::sim
