#include "render/ply_writer.hpp"

#include <fmt/format.h>

#include <bit>
#include <span>

#include "hal/base/bytes.hpp"
#include "hal/base/file.hpp"
#include "ink.hpp"

namespace onemap::render {
namespace {

using mapping::Matrix3d;
using mapping::Rgb;
using mapping::Vector3f;

// The vertex part, which clouds and meshes share.
struct Vertices {
  std::span<const Vector3f> points, normals;
  std::span<const Rgb> colors;
  bool consistent() const {
    return (normals.empty() || normals.size() == points.size()) && (colors.empty() || colors.size() == points.size());
  }
};

std::string header(const Vertices& v, const std::size_t* faces, const Matrix3d& R_file_map) {
  const bool is_turned = R_file_map != Matrix3d::Identity();
  std::string text =
      fmt::format("ply\nformat binary_little_endian 1.0\ncomment metres, y {}\n", is_turned ? "up" : "down");
  if (is_turned) {
    const auto q = mapping::to_quaternion_wxyz(R_file_map);
    text += fmt::format("comment onemap rotation_file_map {} {} {} {}\n", q[0], q[1], q[2], q[3]);  // as they are
  }
  text += fmt::format("element vertex {}\n", v.points.size());
  text += "property float x\nproperty float y\nproperty float z\n";
  if (!v.normals.empty()) text += "property float nx\nproperty float ny\nproperty float nz\n";
  text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (faces != nullptr) text += fmt::format("element face {}\nproperty list uchar uint vertex_indices\n", *faces);
  return text + "end_header\n";
}

void put(ByteWriter& out, const Vector3f& v) {
  for (int i = 0; i < 3; ++i) out.put(std::bit_cast<std::uint32_t>(v[i]));
}

void put_vertices(std::vector<std::uint8_t>& bytes, const Vertices& v, const Matrix3d& R_file_map) {
  ByteWriter out(bytes);
  const Eigen::Matrix3f R = R_file_map.cast<float>();
  for (std::size_t i = 0; i < v.points.size(); ++i) {
    put(out, R * v.points[i]);
    if (!v.normals.empty()) put(out, R * v.normals[i]);
    out.bytes(v.colors.empty() ? kUncoloured : v.colors[i]);
  }
}

std::vector<std::uint8_t> begin(const Vertices& v, const std::size_t* faces, const Matrix3d& R_file_map) {
  const std::string text = header(v, faces, R_file_map);
  std::vector<std::uint8_t> bytes;
  bytes.reserve(text.size() + 27 * v.points.size() + (faces != nullptr ? 13 * *faces : 0));
  bytes.assign(text.begin(), text.end());
  put_vertices(bytes, v, R_file_map);
  return bytes;
}

Error inconsistent(const std::string& path) {
  return Error{path, "cannot write: the map has normals or colours for only a part of its points"};
}

}  // namespace

Status write_ply(const std::string& path, const mapping::TriangleMesh& mesh, const Matrix3d& R_file_map) {
  const Vertices v{mesh.vertices, mesh.normals, mesh.colors};
  if (!v.consistent()) return inconsistent(path);
  const std::size_t faces = mesh.triangles.size();
  std::vector<std::uint8_t> bytes = begin(v, &faces, R_file_map);
  ByteWriter out(bytes);
  for (const auto& triangle : mesh.triangles) {
    out.put(std::uint8_t{3});
    for (const std::uint32_t index : triangle) out.put(index);
  }
  return write_file(path, bytes);
}

Status write_ply(const std::string& path, const mapping::ColoredCloud& cloud, const Matrix3d& R_file_map) {
  const Vertices v{cloud.points, cloud.normals, cloud.colors};
  if (!v.consistent()) return inconsistent(path);
  return write_file(path, begin(v, nullptr, R_file_map));
}

}  // namespace onemap::render
