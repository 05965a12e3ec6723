#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

// Everything that reads bytes from outside, each as a function of any bytes. A target aborts when a promise is broken,
// and sanitizers end it when memory is. tests/fuzz/corpus/NAME holds its inputs.
namespace onemap::fuzz {

using Bytes = std::span<const std::uint8_t>;

void datagram(Bytes input);   // a whole one: what is read encodes to what means the same
void frame(Bytes input);      // first byte: which type; the rest is its body
void node(Bytes input);       // datagrams (length u8, from u8, milliseconds u8, bytes) to a robot, time going on
void record(Bytes input);     // first byte: which kind; the rest is its body
void config(Bytes input);     // the text of a configuration file
void control(Bytes input);    // what a client sends to the control socket
void saved_map(Bytes input);  // a map's file
void image(Bytes input);      // first bytes: which decoder, width, height, bytes a row; the rest is the image

struct Target {
  std::string_view name;
  void (*run)(Bytes input);
};
const std::vector<Target>& targets();

}  // namespace onemap::fuzz
