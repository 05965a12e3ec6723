#pragma once
#include <cmath>
#include <cstdint>

#include "hal/base/splitmix.hpp"

// What decides pixels is built from + - * / sqrt and integers only: the same bits on every machine.
namespace onemap::hal::simulated {

struct Vec3 {
  double x = 0, y = 0, z = 0;
  friend Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
};
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

// Rotation with the camera's axes as columns, given in world coordinates, and the camera's place.
struct CameraPose {
  Vec3 right, down, forward, position;
};

// sin of an angle given in turns, within 1e-11: folded to a quarter turn, then the Taylor series.
inline double sin_turns(double turns) {
  double t = turns - std::floor(turns + 0.5);
  if (t > 0.25) t = 0.5 - t;
  if (t < -0.25) t = -0.5 - t;
  const double x = 6.283185307179586 * t, s = x * x;
  double sum = 0;
  for (int n = 16; n > 0; n -= 2) sum = (1 + sum) * -s / (n * (n + 1));
  return x * (1 + sum);
}
inline double cos_turns(double turns) { return sin_turns(turns + 0.25); }

// A hash of one counter; hash(a, b) chains.
constexpr std::uint64_t hash(std::uint64_t x) { return splitmix64(x); }
constexpr std::uint64_t hash(std::uint64_t a, std::uint64_t b) { return hash(hash(a) ^ b); }

// A stream of numbers from one key: of two like keys the streams have nothing in common.
class Random {
 public:
  explicit Random(std::uint64_t key) : key_(key) {}
  std::uint64_t next() { return hash(key_, count_++); }
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double range(double low, double high) { return low + (high - low) * uniform(); }
  int below(int n) { return static_cast<int>(uniform() * n); }
  bool chance(double p) { return uniform() < p; }

 private:
  std::uint64_t key_, count_ = 0;
};

}  // namespace onemap::hal::simulated
