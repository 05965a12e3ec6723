#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "hal/base/file.hpp"
#include "render/gltf_writer.hpp"
#include "srgb.hpp"
#include "tinygltf.hpp"

namespace onemap::render {
namespace {

using mapping::Vector3f;

// Bounds-checked look at an accessor's elements: nothing if the file does not hold them as announced.
struct Elements {
  const std::uint8_t* data = nullptr;
  std::size_t count = 0, stride = 0;
};

template <class T>
const T* item(const std::vector<T>& items, int index) {
  return index >= 0 && static_cast<std::size_t>(index) < items.size() ? &items[static_cast<std::size_t>(index)]
                                                                      : nullptr;
}

std::optional<Elements> elements(const tinygltf::Model& model, int accessor_index, int component, int type) {
  const auto* accessor = item(model.accessors, accessor_index);
  if (accessor == nullptr || accessor->componentType != component || accessor->type != type ||
      accessor->sparse.isSparse)
    return std::nullopt;
  const auto* view = item(model.bufferViews, accessor->bufferView);
  const auto* buffer = view != nullptr ? item(model.buffers, view->buffer) : nullptr;
  if (buffer == nullptr) return std::nullopt;
  const int component_bytes = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(component));
  const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type));
  const std::size_t size = static_cast<std::size_t>(component_bytes) * static_cast<std::size_t>(components);
  const std::size_t stride = view->byteStride != 0 ? view->byteStride : size;
  const std::size_t available = buffer->data.size();
  if (view->byteOffset > available || accessor->byteOffset > available - view->byteOffset) return std::nullopt;
  const std::size_t begin = view->byteOffset + accessor->byteOffset;
  if (accessor->count == 0 || size > available - begin || accessor->count - 1 > (available - begin - size) / stride)
    return std::nullopt;
  return Elements{buffer->data.data() + begin, accessor->count, stride};
}

std::optional<std::vector<Vector3f>> vectors(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                                             const char* name) {
  const auto found = primitive.attributes.find(name);
  if (found == primitive.attributes.end()) return std::nullopt;
  const auto e = elements(model, found->second, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3);
  if (!e) return std::nullopt;
  std::vector<Vector3f> out(e->count);
  for (std::size_t i = 0; i < e->count; ++i) {
    std::array<float, 3> v{};
    std::memcpy(v.data(), e->data + i * e->stride, sizeof(v));
    out[i] = {v[0], v[1], v[2]};
  }
  return out;
}

std::vector<mapping::Rgb> colors(const tinygltf::Model& model, const tinygltf::Primitive& primitive) {
  const auto found = primitive.attributes.find("COLOR_0");
  if (found == primitive.attributes.end()) return {};
  const auto e = elements(model, found->second, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4);
  if (!e) return {};
  std::vector<mapping::Rgb> out(e->count);
  for (std::size_t i = 0; i < e->count; ++i) {
    std::array<std::uint16_t, 3> v{};
    std::memcpy(v.data(), e->data + i * e->stride, sizeof(v));
    for (std::size_t c = 0; c < 3; ++c) out[i][c] = srgb_from_linear(v[c]);
  }
  return out;
}

std::string read_triangles(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                           mapping::TriangleMesh& mesh) {
  const auto e = elements(model, primitive.indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR);
  if (!e) return "the map's triangles are not as we write them";
  mesh.triangles.resize(e->count / 3);
  for (std::size_t i = 0; i < 3 * mesh.triangles.size(); ++i) {
    std::uint32_t index = 0;
    std::memcpy(&index, e->data + i * e->stride, sizeof(index));
    if (index >= mesh.vertices.size()) return "a triangle of the map has a vertex that does not exist";
    mesh.triangles[i / 3][i % 3] = index;
  }
  return {};
}

std::string read_map(const tinygltf::Model& model, const tinygltf::Node& node, Scene& scene) {
  const auto* mesh = item(model.meshes, node.mesh);
  if (mesh == nullptr || mesh->primitives.empty()) return {};  // an empty map
  const auto& primitive = mesh->primitives[0];
  auto points = vectors(model, primitive, "POSITION");
  if (!points) return "the map's points are not as we write them";
  for (const Vector3f& p : *points)
    if (!p.allFinite()) return "the map has a point that is not finite";
  auto normals = vectors(model, primitive, "NORMAL").value_or(std::vector<Vector3f>());
  auto tones = colors(model, primitive);
  if (normals.size() != points->size()) normals.clear();
  if (tones.size() != points->size()) tones.clear();
  if (primitive.mode == TINYGLTF_MODE_POINTS) {
    scene.points = {std::move(*points), std::move(normals), std::move(tones)};
    return {};
  }
  scene.mesh = {std::move(*points), std::move(normals), std::move(tones), {}};
  return read_triangles(model, primitive, scene.mesh);
}

RobotPath& robot_named(Scene& scene, const std::string& name) {
  for (RobotPath& robot : scene.robots)
    if (robot.name == name) return robot;
  scene.robots.push_back({name, {}, {}, {}});
  return scene.robots.back();
}

void read_color(const tinygltf::Model& model, const tinygltf::Node& node, RobotPath& robot) {
  const auto* mesh = item(model.meshes, node.mesh);
  const auto* material =
      mesh != nullptr && !mesh->primitives.empty() ? item(model.materials, mesh->primitives[0].material) : nullptr;
  if (material == nullptr || material->pbrMetallicRoughness.baseColorFactor.size() < 3) return;
  for (std::size_t c = 0; c < 3; ++c) {
    const double value = std::clamp(material->pbrMetallicRoughness.baseColorFactor[c], 0.0, 1.0);
    robot.color[c] = srgb_from_linear(static_cast<std::uint16_t>(std::lround(value * 65535.0)));
  }
}

void read_trajectory(const tinygltf::Model& model, const tinygltf::Node& node, RobotPath& robot) {
  read_color(model, node, robot);
  const auto* mesh = item(model.meshes, node.mesh);
  if (mesh == nullptr || mesh->primitives.empty()) return;
  const auto points = vectors(model, mesh->primitives[0], "POSITION").value_or(std::vector<Vector3f>());
  for (const Vector3f& p : points) robot.poses.push_back({mapping::Matrix3d::Identity(), p.cast<double>()});
}

void read_cameras(const tinygltf::Model& model, const tinygltf::Node& group, RobotPath& robot) {
  for (const int child : group.children) {
    const auto* node = item(model.nodes, child);
    if (node == nullptr || node->rotation.size() != 4 || node->translation.size() != 3) continue;
    const auto& q = node->rotation;
    const auto& t = node->translation;
    if (!(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] > 0.5)) continue;
    robot.keyframe_poses.push_back({mapping::from_quaternion_wxyz({q[3], q[0], q[1], q[2]}), {t[0], t[1], t[2]}});
    read_color(model, *node, robot);
  }
}

// The name behind a prefix such as "trajectory ".
std::optional<std::string> name_after(const std::string& text, const std::string& prefix) {
  if (text.rfind(prefix, 0) != 0) return std::nullopt;
  return text.substr(prefix.size());
}

}  // namespace

Result<Scene> read_glb(const std::string& path) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  tinygltf::TinyGLTF gltf;
  tinygltf::Model model;
  std::string error, warning;
  if (!gltf.LoadBinaryFromMemory(&model, &error, &warning, bytes->data(), static_cast<unsigned>(bytes->size()))) {
    while (!error.empty() && error.back() == '\n') error.pop_back();
    return Error{path, "not a .glb: " + error};
  }
  const auto* roots = item(model.scenes, std::max(model.defaultScene, 0));
  const auto* root = roots != nullptr && !roots->nodes.empty() ? item(model.nodes, roots->nodes[0]) : nullptr;
  if (root == nullptr) return Error{path, "a .glb without a scene"};
  Scene scene;
  scene.title = root->name;
  bool has_map = false;
  for (const int child : root->children) {
    const auto* node = item(model.nodes, child);
    if (node == nullptr) continue;
    if (node->name == "map") {
      has_map = true;
      if (auto wrong = read_map(model, *node, scene); !wrong.empty()) return Error{path, wrong};
    }
    if (const auto name = name_after(node->name, "trajectory "))
      read_trajectory(model, *node, robot_named(scene, *name));
    if (const auto name = name_after(node->name, "cameras ")) read_cameras(model, *node, robot_named(scene, *name));
  }
  if (!has_map) return Error{path, "a .glb that onemap did not write: it has no node named map"};
  return scene;
}

}  // namespace onemap::render
