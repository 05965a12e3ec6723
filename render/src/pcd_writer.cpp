#include "render/pcd_writer.hpp"

#include <fmt/format.h>

#include <bit>
#include <span>
#include <vector>

#include "hal/base/bytes.hpp"
#include "hal/base/file.hpp"
#include "ink.hpp"

namespace onemap::render {
namespace {

using mapping::Matrix3d;
using mapping::Rgb;
using mapping::Vector3f;
constexpr std::size_t kPointBytes = 16;

// VIEWPOINT stays the identity: some viewers turn the points by it.
std::string header(std::size_t points, const Matrix3d& R_file_map) {
  std::string text = "# .PCD v0.7 - Point Cloud Data file format\n";
  if (R_file_map == Matrix3d::Identity()) {
    text += "# metres, y down\n";
  } else {
    const auto q = mapping::to_quaternion_wxyz(R_file_map);
    text += fmt::format("# metres, y up; onemap rotation_file_map {} {} {} {}\n", q[0], q[1], q[2], q[3]);
  }
  return text + fmt::format(
                    "VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {}\nHEIGHT 1\n"
                    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
                    points, points);
}

Status write(const std::string& path, std::span<const Vector3f> points, std::span<const Rgb> colors,
             const Matrix3d& R_file_map) {
  if (!colors.empty() && colors.size() != points.size())
    return Error{path, "cannot write: the map has colours for only a part of its points"};
  const std::string text = header(points.size(), R_file_map);
  std::vector<std::uint8_t> bytes(text.begin(), text.end());
  bytes.reserve(text.size() + kPointBytes * points.size());
  ByteWriter out(bytes);
  const Eigen::Matrix3f R = R_file_map.cast<float>();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3f p = R * points[i];
    for (int k = 0; k < 3; ++k) out.put(std::bit_cast<std::uint32_t>(p[k]));
    const Rgb& c = colors.empty() ? kUncoloured : colors[i];
    out.put(std::uint32_t{c[0]} << 16 | std::uint32_t{c[1]} << 8 | std::uint32_t{c[2]});
  }
  return write_file(path, bytes);
}

}  // namespace

Status write_pcd(const std::string& path, const mapping::TriangleMesh& mesh, const Matrix3d& R_file_map) {
  return write(path, mesh.vertices, mesh.colors, R_file_map);
}

Status write_pcd(const std::string& path, const mapping::ColoredCloud& cloud, const Matrix3d& R_file_map) {
  return write(path, cloud.points, cloud.colors, R_file_map);
}

}  // namespace onemap::render
