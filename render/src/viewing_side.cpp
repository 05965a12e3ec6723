#include "viewing_side.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace onemap::render {
namespace {

constexpr float kUpright = 0.2f;     // of a wall's normal along up, at most
constexpr float kAlongWalls = 1.2f;  // what a view along walls may show less than another
constexpr std::array<float, 3> kLookDownAround{0.8f, 1.0f, 1.25f};

// Level, and at right angles to most of what stands upright, or along it: four times an angle is the same for both.
glm::vec3 along_the_walls(const std::vector<Sample>& samples, const glm::vec3& up) {
  const Frame level = make_frame(some_level(up), up);
  float cosines = 0, sines = 0;
  for (const Sample& s : samples) {
    if (glm::length(s.normal) < 0.5f || std::abs(glm::dot(s.normal, up)) > kUpright) continue;
    const float angle = 4 * std::atan2(glm::dot(s.normal, level.right), glm::dot(s.normal, level.forward));
    cosines += std::cos(angle);
    sines += std::sin(angle);
  }
  const float angle = 0.25f * std::atan2(sines, cosines);  // 0 without walls
  return std::cos(angle) * level.forward + std::sin(angle) * level.right;
}

// Of many at most so many, evenly.
std::vector<Sample> some_of(const std::vector<Sample>& samples, std::size_t most) {
  std::vector<Sample> some;
  for (std::size_t i = 0; i < samples.size(); i += samples.size() / most + 1) some.push_back(samples[i]);
  return some;
}

}  // namespace

Frame make_frame(const glm::vec3& forward, const glm::vec3& up) {
  const glm::vec3 f = glm::normalize(forward);
  glm::vec3 right = glm::cross(f, up);
  if (glm::length(right) < 1e-3f) right = glm::cross(f, std::abs(f.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1));
  right = glm::normalize(right);
  return {right, glm::cross(right, f), f};
}

glm::vec3 some_level(const glm::vec3& up) {
  return std::abs(up.z) < 0.9f ? glm::vec3(0, 0, 1) - up * up.z : glm::vec3(1, 0, 0) - up * up.x;
}

bool faces(const Sample& s, const glm::vec3& towards_eye) { return glm::dot(s.normal, towards_eye) >= 0; }

Box seen_box(const std::vector<Sample>& samples, const Frame& frame) {
  Box box;
  for (const Sample& s : samples)
    if (faces(s, -frame.forward))
      box.add({glm::dot(s.point, frame.right), glm::dot(s.point, frame.up), glm::dot(s.point, frame.forward)});
  if (box.low.x > box.high.x) box.add(glm::vec3(0.0f));
  return box;
}

Frame best_side(const std::vector<Sample>& all, const glm::vec3& up, float aspect) {
  const std::vector<Sample> samples = some_of(all, 20000);
  const Frame first = make_frame(along_the_walls(samples, up), up);
  Frame best = first;
  float best_score = -1;
  for (int i = 0; i < 36 * static_cast<int>(kLookDownAround.size()); ++i) {
    const float angle = 0.17453293f * static_cast<float>(i % 36);
    const glm::vec3 level = std::cos(angle) * first.forward + std::sin(angle) * first.right;
    const Frame frame = make_frame(level - kLookDownAround[static_cast<std::size_t>(i / 36)] * first.up, first.up);
    const Box box = seen_box(samples, frame);
    const float width = std::max(box.high.x - box.low.x, 0.01f), height = std::max(box.high.y - box.low.y, 0.01f);
    const float scale = std::min(aspect / width, 1 / height);
    float surface = 0;
    for (const Sample& s : samples) surface += std::max(0.0f, -glm::dot(s.normal, frame.forward));
    const float score = surface * scale * scale * (i % 9 == 0 ? kAlongWalls : 1);
    if (score <= best_score) continue;
    best_score = score;
    best = frame;
  }
  return best;
}

Frame from_above(const std::vector<Sample>& samples, const glm::vec3& up, const glm::vec3& away, float aspect) {
  const std::vector<Sample> some = some_of(samples, 4000);
  const Frame first = make_frame(-up, away);
  Frame best = first;
  float best_scale = 0;
  for (int i = 0; i < 180; ++i) {  // the nearest to `away` first
    const float angle = 0.017453293f * static_cast<float>(i % 2 == 0 ? i / 2 : -(i + 1) / 2);
    const Frame frame = make_frame(-up, std::cos(angle) * first.up + std::sin(angle) * first.right);
    const Box box = seen_box(some, frame);
    const float width = std::max(box.high.x - box.low.x, 0.01f), height = std::max(box.high.y - box.low.y, 0.01f);
    const float scale = std::min(aspect / width, 1 / height);
    if (scale <= 1.001f * best_scale) continue;
    best_scale = scale;
    best = frame;
  }
  return best;
}

}  // namespace onemap::render
