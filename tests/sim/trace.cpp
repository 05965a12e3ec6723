// What goes over the net, in words.
#include <fmt/format.h>

#include "session/sealed_wire.hpp"
#include "sim/play.hpp"

namespace onemap::comms::sim {

namespace {
struct Words {
  std::string operator()(const wire::Beacon& f) const {
    return fmt::format("beacon({}, {:08x})", f.robot.name(), f.frontier_digest >> 32);
  }
  std::string operator()(const wire::Status& f) const { return fmt::format("status({})", f.robots.size()); }
  std::string operator()(const wire::Have& f) const {
    std::string text = fmt::format("have({:08x}", f.frontier_digest >> 32);
    for (const auto& e : f.entries)
      text += fmt::format(" {}/{}/{}:{}", e.log.robot.name(), e.log.incarnation, e.log.lane, e.count);
    return text + ")";
  }
  std::string operator()(const wire::HaveRequest&) const { return "have_request"; }
  std::string operator()(const wire::Want& f) const {
    std::string text = fmt::format("want({}", f.credit_bytes);
    for (const auto& e : f.entries)
      text += fmt::format(" {}/{}/{}#{}:{}+{}", e.id.log.robot.name(), e.id.log.incarnation, e.id.log.lane, e.id.seq,
                          e.first, e.count);
    return text + ")";
  }
  std::string operator()(const wire::Data& f) const {
    return fmt::format("data({}/{}/{}#{}:{}, {} of {} bytes)", f.id.log.robot.name(), f.id.log.incarnation,
                       f.id.log.lane, f.id.seq, f.fragment, f.bytes.size(), f.total_bytes);
  }
  std::string operator()(const wire::Ping& f) const { return fmt::format("ping({})", f.token); }
  std::string operator()(const wire::Pong& f) const { return fmt::format("pong({})", f.token); }
  std::string operator()(const wire::LaterLife& f) const {
    return fmt::format("later_life({}, {})", f.robot.name(), f.incarnation);
  }
  std::string operator()(const wire::Mass& f) const {
    return fmt::format("mass({:x}, {:.2f}{})", f.round, f.heard / 65535.0, f.has_amounts ? ", amounts" : "");
  }
  template <class Other>
  std::string operator()(const Other&) const {
    return "another frame";
  }
};

// What can be seen of it without a key.
std::string sealed_words(std::span<const std::uint8_t> bytes) {
  using sealed::Type;
  Type type{};
  if (sealed::read_head(bytes, type) != Refusal::count) return "no sealed datagram";
  const auto index = [&](std::size_t at) { return fmt::format("{:08x}", sealed::index_at(bytes, at)); };
  switch (type) {
    case Type::hello:
      return "hello of " + index(4);
    case Type::answer:
      return "answer of " + index(4) + " to " + index(8);
    case Type::proof:
      return "proof of " + index(4) + " to " + index(8);
    case Type::cookie:
      return "cookie to " + index(4);
    case Type::frames:
      return fmt::format("{} bytes of frames to {}, number {}", bytes.size(), index(4), sealed::counter_of(bytes));
    case Type::own:
      return "own word to " + index(4);
    case Type::group:
      return "group beacon";
  }
  return "?";
}
}  // namespace

void Play::tell(const Trace& trace) {
  net_.tap = [this, trace](std::size_t to, const Endpoint& from, std::span<const std::uint8_t> bytes) {
    if (scenario_.sealed && to < scenario_.robots)
      return trace(fmt::format("{:10.6f} s  {}.{} to {}: {}", to_seconds(net_.now().time_since_epoch()) - 1,
                               from.address[14], from.address[15], to, sealed_words(bytes)));
    wire::Decoder decoder;
    std::string line = fmt::format("{:10.6f} s  {}.{} to {}: ", to_seconds(net_.now().time_since_epoch()) - 1,
                                   from.address[14], from.address[15], to);
    if (const Refusal why = decoder.decode(bytes); why != Refusal::count)
      return trace(line + fmt::format("{} bytes, {}", bytes.size(), comms::name(why)));
    const wire::Header& header = decoder.header();
    line += fmt::format("{} of {} to {} counter {}", header.type == wire::DatagramType::group ? "group" : "unicast",
                        header.sender, header.receiver, header.counter);
    for (const wire::Frame& frame : decoder.frames()) line += " " + std::visit(Words{}, frame);
    trace(line);
  };
}

}  // namespace onemap::comms::sim
