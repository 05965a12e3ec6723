#pragma once
#include <cstdint>
#include <functional>

namespace onemap::comms {

// How long the body of a record counts. Every robot must say the same of every kind.
enum class Keeping : std::uint8_t {
  always,
  until_the_next,   // of its kind in its log, which says by itself that it takes its place
  until_it_may_go,  // once a later record of its log and kind says so, and Node::let_go() is called
};
using KeepingOf = std::function<Keeping(std::uint16_t kind)>;

}  // namespace onemap::comms
