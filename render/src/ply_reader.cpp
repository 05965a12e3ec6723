#include "render/ply_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "hal/base/bytes.hpp"
#include "hal/base/file.hpp"
#include "render/upright.hpp"

namespace onemap::render {
namespace {

enum class Type : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

std::optional<Type> type_from_name(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, Type>, 16> kNames{{{"char", Type::i8},
                                                                             {"int8", Type::i8},
                                                                             {"uchar", Type::u8},
                                                                             {"uint8", Type::u8},
                                                                             {"short", Type::i16},
                                                                             {"int16", Type::i16},
                                                                             {"ushort", Type::u16},
                                                                             {"uint16", Type::u16},
                                                                             {"int", Type::i32},
                                                                             {"int32", Type::i32},
                                                                             {"uint", Type::u32},
                                                                             {"uint32", Type::u32},
                                                                             {"float", Type::f32},
                                                                             {"float32", Type::f32},
                                                                             {"double", Type::f64},
                                                                             {"float64", Type::f64}}};
  for (const auto& [text, type] : kNames)
    if (text == name) return type;
  return std::nullopt;
}

struct Property {
  std::string name;
  Type type{};
  std::optional<Type> list_count;  // set: a list of `type` with its length first
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool ascii = false;
  std::vector<Element> elements;
  std::size_t size_bytes = 0;
  mapping::Matrix3d R_file_map = mapping::Matrix3d::Identity();
};

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (;;) {
    const std::size_t from = line.find_first_not_of(" \t\r");
    if (from == std::string_view::npos) return words;
    line.remove_prefix(from);
    const std::size_t size = std::min(line.find_first_of(" \t\r"), line.size());
    words.push_back(line.substr(0, size));
    line.remove_prefix(size);
  }
}

// What our writer says about the frame; any other comment is none of ours.
std::string parse_comment(const std::vector<std::string_view>& words, Header& header) {
  if (words.size() != 7 || words[1] != "onemap" || words[2] != "rotation_file_map") return {};
  std::array<double, 4> q{};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::string_view word = words[3 + i];
    const auto parsed = std::from_chars(word.data(), word.data() + word.size(), q[i]);
    if (parsed.ec != std::errc{} || parsed.ptr != word.data() + word.size()) return "a rotation that is no number";
  }
  const double squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!(std::abs(squared - 1) < 1e-3)) return "a rotation that is no unit quaternion";
  header.R_file_map = mapping::from_quaternion_wxyz(q);
  return {};
}

// One line of the header; an empty string, or what is wrong with it.
std::string parse_line(const std::vector<std::string_view>& words, Header& header) {
  const std::string_view key = words[0];
  if (key == "comment") return parse_comment(words, header);
  if (key == "obj_info") return {};
  if (key == "format" && words.size() >= 2) {
    if (words[1] != "ascii" && words[1] != "binary_little_endian")
      return fmt::format("format {} is not supported (ascii and binary_little_endian are)", words[1]);
    header.ascii = words[1] == "ascii";
    return {};
  }
  if (key == "element" && words.size() == 3) {
    Element element{std::string(words[1]), 0, {}};
    const auto parsed = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
    if (parsed.ec != std::errc{} || parsed.ptr != words[2].data() + words[2].size()) return "a count that is no number";
    header.elements.push_back(std::move(element));
    return {};
  }
  if (key != "property" || header.elements.empty()) return fmt::format("unknown keyword {}", key);
  const bool list = words.size() == 5 && words[1] == "list";
  if (!list && words.size() != 3) return "an incomplete property";
  const auto type = type_from_name(words[list ? 3 : 1]);
  const auto count = list ? type_from_name(words[2]) : std::optional<Type>{};
  if (!type || (list && !count)) return "an unknown property type";
  header.elements.back().properties.push_back({std::string(words.back()), *type, count});
  return {};
}

Result<Header> parse_header(std::string_view text, const std::string& name) {
  Header header;
  bool format_known = false;
  for (int line_number = 1;; ++line_number) {
    const std::size_t end = text.find('\n', header.size_bytes);
    if (end == std::string_view::npos) return Error{name, "not a PLY file: the header has no end"};
    const auto words = words_of(text.substr(header.size_bytes, end - header.size_bytes));
    header.size_bytes = end + 1;
    const std::string place = fmt::format("{}:{}", name, line_number);
    if (line_number == 1) {
      if (words.size() != 1 || words[0] != "ply") return Error{name, "not a PLY file"};
      continue;
    }
    if (words.empty()) continue;
    if (words[0] == "end_header") break;
    format_known = format_known || words[0] == "format";
    if (auto wrong = parse_line(words, header); !wrong.empty()) return Error{place, wrong};
  }
  if (!format_known) return Error{name, "the header states no format"};
  return header;
}

// The values after the header, one by one, whatever their encoding.
class Values {
 public:
  Values(std::span<const std::uint8_t> data, bool ascii) : ascii_(ascii), reader_(data), text_(data) {}
  double next(Type type) { return ascii_ ? next_word() : next_binary(type); }
  bool ok() const { return ok_ && reader_.ok(); }
  std::size_t remaining() const { return ascii_ ? text_.size() : reader_.remaining(); }

 private:
  double next_binary(Type type) {
    switch (type) {
      case Type::i8:
        return reader_.get<std::int8_t>();
      case Type::u8:
        return reader_.get<std::uint8_t>();
      case Type::i16:
        return reader_.get<std::int16_t>();
      case Type::u16:
        return reader_.get<std::uint16_t>();
      case Type::i32:
        return reader_.get<std::int32_t>();
      case Type::u32:
        return reader_.get<std::uint32_t>();
      case Type::f32:
        return std::bit_cast<float>(reader_.get<std::uint32_t>());
      case Type::f64:
        return std::bit_cast<double>(reader_.get<std::uint64_t>());
    }
    return 0;
  }

  double next_word() {
    const auto space = [](std::uint8_t c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    while (!text_.empty() && space(text_[0])) text_ = text_.subspan(1);
    std::size_t size = 0;
    std::array<char, 64> word{};
    while (size < text_.size() && size < word.size() && !space(text_[size])) {
      word[size] = static_cast<char>(text_[size]);
      ++size;
    }
    text_ = text_.subspan(size);
    double value = 0;
    const auto parsed = std::from_chars(word.data(), word.data() + size, value);
    if (parsed.ec != std::errc{} || parsed.ptr != word.data() + size) ok_ = false;
    return value;
  }

  bool ascii_, ok_ = true;
  ByteReader reader_;
  std::span<const std::uint8_t> text_;
};

// Where the properties that we use stand in a vertex; -1: absent.
struct Layout {
  std::array<int, 3> position{-1, -1, -1}, normal{-1, -1, -1}, color{-1, -1, -1};
  static bool complete(const std::array<int, 3>& at) { return at[0] >= 0 && at[1] >= 0 && at[2] >= 0; }
};

Layout layout_of(const Element& vertex) {
  static constexpr std::array<const char*, 9> kNames{"x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"};
  Layout layout;
  for (std::size_t i = 0; i < vertex.properties.size(); ++i) {
    for (std::size_t k = 0; k < kNames.size(); ++k) {
      if (vertex.properties[i].name != kNames[k]) continue;
      if (k >= 6 && vertex.properties[i].type != Type::u8) continue;  // colours in other units: none
      auto& group = k < 3 ? layout.position : k < 6 ? layout.normal : layout.color;
      group[k % 3] = static_cast<int>(i);
    }
  }
  return layout;
}

std::uint8_t to_byte(double value) {
  return value > 0 ? static_cast<std::uint8_t>(std::min(value, 255.0)) : std::uint8_t{0};
}

// Reads one item of an element: a scalar a property into `scalars`, the last list into `list`.
void read_item(const Element& element, Values& values, std::vector<double>& scalars, std::vector<double>& list) {
  for (std::size_t i = 0; i < element.properties.size() && values.ok(); ++i) {
    const Property& property = element.properties[i];
    if (!property.list_count) {
      scalars[i] = values.next(property.type);
      continue;
    }
    const double count = values.next(*property.list_count);
    list.clear();
    for (double k = 0; k < count && values.ok(); ++k) list.push_back(values.next(property.type));
  }
}

void add_vertex(const Layout& layout, const std::vector<double>& v, mapping::TriangleMesh& mesh) {
  const auto vector = [&](const std::array<int, 3>& at) {
    return mapping::Vector3f(static_cast<float>(v[static_cast<std::size_t>(at[0])]),
                             static_cast<float>(v[static_cast<std::size_t>(at[1])]),
                             static_cast<float>(v[static_cast<std::size_t>(at[2])]));
  };
  mesh.vertices.push_back(vector(layout.position));
  if (Layout::complete(layout.normal)) mesh.normals.push_back(vector(layout.normal));
  if (!Layout::complete(layout.color)) return;
  mapping::Rgb color{};
  for (std::size_t c = 0; c < 3; ++c) color[c] = to_byte(v[static_cast<std::size_t>(layout.color[c])]);
  mesh.colors.push_back(color);
}

void add_face(const std::vector<double>& corners, mapping::TriangleMesh& mesh) {
  const auto index = [&](std::size_t i) {
    const bool possible = corners[i] >= 0 && corners[i] < 4294967295.0;  // false for NaN too; check() refuses the rest
    return possible ? static_cast<std::uint32_t>(corners[i]) : 0xFFFFFFFFu;
  };
  for (std::size_t i = 2; i < corners.size(); ++i) mesh.triangles.push_back({index(0), index(i - 1), index(i)});
}

std::string check(const mapping::TriangleMesh& mesh) {
  for (const auto& v : mesh.vertices)
    if (!v.allFinite()) return "a point that is not finite";
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t index : triangle)
      if (index >= mesh.vertices.size()) return fmt::format("a face with vertex {} of {}", index, mesh.vertices.size());
  return {};
}

}  // namespace

Result<mapping::TriangleMesh> parse_ply(std::span<const std::uint8_t> bytes, const std::string& name) {
  const std::string text_header(
      bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(bytes.size(), 65536)));
  auto header = parse_header(text_header, name);
  if (!header) return header.error();
  Values values(bytes.subspan(header->size_bytes), header->ascii);
  mapping::TriangleMesh mesh;
  bool has_vertices = false;
  for (const Element& element : header->elements) {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    const Layout layout = layout_of(element);
    if (is_vertex && !Layout::complete(layout.position)) return Error{name, "the vertices have no x, y, z"};
    if (element.count > 0 && element.properties.empty())
      return Error{name, "element " + element.name + " has no properties"};
    has_vertices = has_vertices || is_vertex;
    std::vector<double> scalars(element.properties.size()), list;
    for (std::uint64_t i = 0; i < element.count; ++i) {
      read_item(element, values, scalars, list);
      if (!values.ok())
        return Error{fmt::format("{}, {} {} of {}", name, element.name, i, element.count), "cut short or not a number"};
      if (is_vertex) add_vertex(layout, scalars, mesh);
      if (is_face) add_face(list, mesh);
    }
  }
  if (!has_vertices) return Error{name, "no vertices"};
  if (auto wrong = check(mesh); !wrong.empty()) return Error{name, wrong};
  if (header->R_file_map == mapping::Matrix3d::Identity()) return mesh;
  return turned(std::move(mesh), header->R_file_map.transpose());
}

Result<mapping::TriangleMesh> read_ply(const std::string& path) {
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return parse_ply(*bytes, path);
}

}  // namespace onemap::render
