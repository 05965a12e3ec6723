#include "render/gltf_writer.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <sstream>

#include "hal/base/file.hpp"
#include "markers.hpp"
#include "render/upright.hpp"
#include "srgb.hpp"
#include "tinygltf.hpp"

namespace onemap::render {
namespace {

using mapping::Rgb;
using mapping::Vector3f;

double linear(std::uint8_t srgb) { return linear_from_srgb(srgb) / 65535.0; }

// Collects a model with one buffer; every add_ function returns the index of what it added.
class Builder {
 public:
  Builder(const std::string& title, const mapping::Matrix3d& R_upright_scene) {
    model_.asset.version = "2.0";
    model_.asset.generator = "onemap";
    model_.extensionsUsed = {"KHR_materials_unlit"};
    model_.buffers.emplace_back();
    model_.nodes.emplace_back();
    model_.nodes[0].name = title.empty() ? "scene" : title;
    const auto q = mapping::to_quaternion_wxyz(R_upright_scene);
    model_.nodes[0].rotation = {q[1], q[2], q[3], q[0]};
    model_.scenes.emplace_back();
    model_.scenes[0].nodes = {0};
    model_.defaultScene = 0;
  }

  int add_node(const std::string& name, int parent, int mesh) {
    tinygltf::Node node;
    node.name = name;
    node.mesh = mesh;
    model_.nodes.push_back(std::move(node));
    const int index = static_cast<int>(model_.nodes.size()) - 1;
    model_.nodes[static_cast<std::size_t>(parent)].children.push_back(index);
    return index;
  }
  tinygltf::Node& node(int index) { return model_.nodes[static_cast<std::size_t>(index)]; }

  int add_mesh(const std::string& name, tinygltf::Primitive primitive) {
    tinygltf::Mesh mesh;
    mesh.name = name;
    mesh.primitives.push_back(std::move(primitive));
    model_.meshes.push_back(std::move(mesh));
    return static_cast<int>(model_.meshes.size()) - 1;
  }

  int add_material(const std::string& name, const Color& color, bool double_sided) {
    tinygltf::Material material;
    material.name = name;
    material.doubleSided = double_sided;
    material.pbrMetallicRoughness.baseColorFactor = {linear(color[0]), linear(color[1]), linear(color[2]), 1};
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 0.9;
    material.extensions["KHR_materials_unlit"] = tinygltf::Value(tinygltf::Value::Object());
    model_.materials.push_back(std::move(material));
    return static_cast<int>(model_.materials.size()) - 1;
  }

  int add_accessor(const void* data, std::size_t size_bytes, std::size_t count, int component, int type, int target) {
    auto& bytes = model_.buffers[0].data;  // every part is a multiple of four bytes long: all stay aligned
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = size_bytes;
    view.target = target;
    model_.bufferViews.push_back(view);
    bytes.resize(bytes.size() + size_bytes);
    std::memcpy(bytes.data() + view.byteOffset, data, size_bytes);
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size()) - 1;
    accessor.componentType = component;
    accessor.count = count;
    accessor.type = type;
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  int add_vectors(const std::vector<Vector3f>& v) {
    return add_accessor(v.data(), v.size() * sizeof(Vector3f), v.size(), TINYGLTF_COMPONENT_TYPE_FLOAT,
                        TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER);
  }

  int add_positions(const std::vector<Vector3f>& points) {
    const int index = add_vectors(points);
    Vector3f low = points.front(), high = points.front();
    for (const Vector3f& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    auto& accessor = model_.accessors[static_cast<std::size_t>(index)];
    accessor.minValues = {low.x(), low.y(), low.z()};
    accessor.maxValues = {high.x(), high.y(), high.z()};
    return index;
  }

  int add_colors(const std::vector<Rgb>& colors) {
    std::vector<std::array<std::uint16_t, 4>> rgba(colors.size());
    for (std::size_t i = 0; i < colors.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) rgba[i][c] = linear_from_srgb(colors[i][c]);
      rgba[i][3] = 65535;
    }
    const int index = add_accessor(rgba.data(), rgba.size() * 8, rgba.size(), TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                                   TINYGLTF_TYPE_VEC4, TINYGLTF_TARGET_ARRAY_BUFFER);
    model_.accessors[static_cast<std::size_t>(index)].normalized = true;
    return index;
  }

  int add_indices(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
    return add_accessor(triangles.data(), triangles.size() * 12, 3 * triangles.size(),
                        TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR,
                        TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  }

  tinygltf::Model finish() {
    if (model_.buffers[0].data.empty()) model_.buffers.clear();  // glTF has no empty buffers
    if (model_.materials.empty()) model_.extensionsUsed.clear();
    return std::move(model_);
  }

 private:
  tinygltf::Model model_;
};

// glTF wants unit normals; a vertex without one gets any.
std::vector<Vector3f> unit_normals(const std::vector<Vector3f>& normals) {
  std::vector<Vector3f> out = normals;
  for (Vector3f& n : out) {
    const float length = n.norm();
    n = length > 1e-6f && n.allFinite() ? Vector3f(n / length) : Vector3f(0, 0, -1);
  }
  return out;
}

void add_map(Builder& builder, const Scene& scene) {
  const bool meshed = !scene.mesh.vertices.empty();
  const auto& points = meshed ? scene.mesh.vertices : scene.points.points;
  const auto& normals = meshed ? scene.mesh.normals : scene.points.normals;
  const auto& colors = meshed ? scene.mesh.colors : scene.points.colors;
  const bool triangles = meshed && !scene.mesh.triangles.empty();
  if (points.empty()) {
    builder.add_node("map", 0, -1);
    return;
  }
  tinygltf::Primitive primitive;
  primitive.mode = triangles ? TINYGLTF_MODE_TRIANGLES : TINYGLTF_MODE_POINTS;
  primitive.material = builder.add_material("map", {255, 255, 255}, false);
  primitive.attributes["POSITION"] = builder.add_positions(points);
  if (!normals.empty()) primitive.attributes["NORMAL"] = builder.add_vectors(unit_normals(normals));
  if (!colors.empty()) primitive.attributes["COLOR_0"] = builder.add_colors(colors);
  if (triangles) primitive.indices = builder.add_indices(scene.mesh.triangles);
  builder.add_node("map", 0, builder.add_mesh("map", std::move(primitive)));
}

void add_trajectory(Builder& builder, const RobotPath& robot, int material) {
  if (robot.poses.size() < 2) return;  // a line strip has at least two points
  std::vector<Vector3f> points;
  points.reserve(robot.poses.size());
  for (const auto& pose : robot.poses) points.emplace_back(pose.t.cast<float>());
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_LINE_STRIP;
  primitive.material = material;
  primitive.attributes["POSITION"] = builder.add_positions(points);
  const std::string name = "trajectory " + robot.name;
  builder.add_node(name, 0, builder.add_mesh(name, std::move(primitive)));
}

// One pyramid in the camera's frame that all keyframes' nodes share.
int add_pyramid(Builder& builder, const RobotPath& robot, int material, float depth_m) {
  const auto corners = pyramid(mapping::Pose{}, depth_m);
  std::vector<Vector3f> points;
  points.reserve(corners.size());
  for (const glm::vec3& p : corners) points.emplace_back(p.x, p.y, p.z);
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = material;
  primitive.attributes["POSITION"] = builder.add_positions(points);
  primitive.indices = builder.add_indices({{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}});
  return builder.add_mesh("camera " + robot.name, std::move(primitive));
}

void add_cameras(Builder& builder, const RobotPath& robot, int material, float depth_m) {
  if (robot.keyframe_poses.empty()) return;
  const int mesh = add_pyramid(builder, robot, material, depth_m);
  const int group = builder.add_node("cameras " + robot.name, 0, -1);
  for (std::size_t i = 0; i < robot.keyframe_poses.size(); ++i) {
    const mapping::Pose& pose = robot.keyframe_poses[i];
    const int index = builder.add_node(robot.name + " keyframe " + std::to_string(i), group, mesh);
    const auto q = mapping::to_quaternion_wxyz(pose.R);
    builder.node(index).rotation = {q[1], q[2], q[3], q[0]};
    builder.node(index).translation = {pose.t.x(), pose.t.y(), pose.t.z()};
  }
}

bool all_finite(const std::vector<Vector3f>& points) {
  return std::all_of(points.begin(), points.end(), [](const Vector3f& p) { return p.allFinite(); });
}

std::string check(const Scene& scene) {
  const auto fits = [](std::size_t part, std::size_t all) { return part == 0 || part == all; };
  const auto& m = scene.mesh;
  const auto& c = scene.points;
  if (!fits(m.normals.size(), m.vertices.size()) || !fits(m.colors.size(), m.vertices.size()) ||
      !fits(c.normals.size(), c.points.size()) || !fits(c.colors.size(), c.points.size()))
    return "the map has normals or colours for only a part of its points";
  if (!all_finite(m.vertices) || !all_finite(c.points)) return "the map has a point that is not finite";
  for (const RobotPath& robot : scene.robots)
    for (const auto* poses : {&robot.poses, &robot.keyframe_poses})
      for (const auto& pose : *poses)
        if (!pose.t.allFinite() || !pose.R.allFinite()) return "robot " + robot.name + " has a pose that is not finite";
  return {};
}

}  // namespace

Status write_glb(const std::string& path, const Scene& scene) {
  if (auto wrong = check(scene); !wrong.empty()) return Error{path, "cannot write: " + wrong};
  Builder builder(scene.title, upright_rotation(up_of(scene)));
  const float depth_m = choose_markers(scene).depth_m;
  add_map(builder, scene);
  for (const RobotPath& robot : scene.robots) {
    if (robot.poses.size() < 2 && robot.keyframe_poses.empty()) continue;
    const int material = builder.add_material(robot.name, robot.color, true);
    add_trajectory(builder, robot, material);
    add_cameras(builder, robot, material, depth_m);
  }
  const tinygltf::Model model = builder.finish();
  std::ostringstream out;
  tinygltf::TinyGLTF gltf;
  if (!gltf.WriteGltfSceneToStream(&model, out, false, true))
    return Error{path, "cannot write: glTF refused the scene"};
  const std::string bytes = std::move(out).str();
  return write_file(path, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

}  // namespace onemap::render
