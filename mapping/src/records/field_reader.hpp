#pragma once
#include <string>
#include <string_view>

#include "hal/base/bytes.hpp"
#include "hal/base/ids.hpp"
#include "hal/base/result.hpp"
#include "hal/base/time.hpp"
#include "mapping/geometry.hpp"
#include "mapping/records/chain_id.hpp"

namespace onemap::mapping {

// Reads the fields of one record and remembers the first that is wrong. After a failure every read gives zeros, so a
// decoder reads straight on and asks finish() once; loops are bounded because count() gives 0 after a failure.
class FieldReader {
 public:
  FieldReader(std::string_view kind, std::span<const std::uint8_t> body) : kind_(kind), reader_(body) {}

  template <std::integral T>
  T get(std::string_view field) {
    const T value = reader_.get<T>();
    require(reader_.ok(), field, "cut short");
    return ok() ? value : T{};
  }
  std::span<const std::uint8_t> bytes(std::size_t count, std::string_view field) {
    const auto part = reader_.bytes(count);
    require(reader_.ok(), field, "cut short");
    return part;
  }
  // A number of items that each take at least item_bytes: bounded before anything is allocated for them.
  template <std::integral T>
  std::size_t count(std::size_t most, std::size_t item_bytes, std::string_view field) {
    const auto n = static_cast<std::size_t>(get<T>(field));
    require(n <= most, field, "more than allowed");
    require(n * item_bytes <= reader_.remaining(), field, "more than the record holds");
    return ok() ? n : 0;
  }
  RobotId robot(std::string_view field);  // refuses what is no valid name
  ChainId chain(std::string_view field);
  QuantizedPose pose(std::string_view field);  // refuses quaternions that are not of unit length with w >= 0
  FrameTime time(std::string_view field) { return frame_time_from_ns(get<std::int64_t>(field)); }

  void require(bool good, std::string_view field, std::string_view why) {
    if (good || !ok()) return;
    error_ = {std::string(kind_) + " record, " + std::string(field), std::string(why)};
  }
  bool ok() const { return error_.place.empty(); }
  std::size_t remaining() const { return reader_.remaining(); }

  template <class T>
  Result<T> finish(T value) {
    require(reader_.remaining() == 0, "end", "bytes follow");
    if (!ok()) return error_;
    return value;
  }

 private:
  std::string_view kind_;
  ByteReader reader_;
  Error error_;
};

inline constexpr std::size_t kPoseBytes = 28;  // of an encoded QuantizedPose

void put(ByteWriter& out, const RobotId& robot);
void put(ByteWriter& out, const ChainId& chain);
void put(ByteWriter& out, const QuantizedPose& pose);
void put(ByteWriter& out, FrameTime time);

}  // namespace onemap::mapping
