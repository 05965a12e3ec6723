#include "font.hpp"

#include <algorithm>
#include <array>

namespace onemap::render {
namespace {

// From '!' on. Strokes are separated by spaces; a stroke is a row of places, x as a digit and y as a letter (A 4 below
// the base line, E on it, M the height of small letters, Q that of capitals). ~ before a stroke: a smooth curve along
// its places; @: a smooth closed one.
constexpr std::array<std::string_view, 94> kGlyphs{"0Q0I 0E0F",                             // !
                                                   "0Q0N 3Q3N",                             // "
                                                   "2E3Q 5E6Q 0I8I 0M8M",                   // #
                                                   "~7O5P2P0N1K6K8I6G3F0G 4Q4E",            // $
                                                   "0E7Q @0O1Q2Q3O2M1M @4G5I6I7G6E5E",      // %
                                                   "~8E3L1N2Q4Q5N3L0J0F2E5E8I",             // &
                                                   "0Q0N",                                  // '
                                                   "~3Q0N0F3C",                             // (
                                                   "~0Q3N3F0C",                             // )
                                                   "3M3G 0L6H 6L0H",                        // *
                                                   "0J6J 3G3M",                             // +
                                                   "1F0C",                                  // ,
                                                   "0J4J",                                  // -
                                                   "0E1E1F0F0E",                            // .
                                                   "0D5Q",                                  // /
                                                   "@2E0H0N2Q4Q6N6H4E",                     // 0
                                                   "0N3Q3E",                                // 1
                                                   "~0N1Q5Q6N6L3I0E 0E6E",                  // 2
                                                   "~0P2Q6Q6L3K ~3K7K7E2E0F",               // 3
                                                   "5E5Q0H7H",                              // 4
                                                   "5Q1Q0K ~0K2L6M7H5E2E0F",                // 5
                                                   "~5P3Q0N0H ~0H0E3E6E6I3L0J0H",           // 6
                                                   "0Q6Q2E",                                // 7
                                                   "@3K1L0N1Q5Q6N5L @3K0J0F2E4E6F6J",       // 8
                                                   "~6M6N6Q3Q0Q0M3J6L6M ~6M6G3E1F",         // 9
                                                   "0E0F 0L0M",                             // :
                                                   "1F0C 1L1M",                             // ;
                                                   "5M0J5G",                                // <
                                                   "0H6H 0L6L",                             // =
                                                   "0M5J0G",                                // >
                                                   "~0N1Q5Q6N5L3J3H 3E3F",                  // ?
                                                   "~6H3H2L5N6L6H8H8Q0Q0E7E",               // @
                                                   "0E4Q8E 1H7H",                           // A
                                                   "0E0Q4Q ~4Q8Q8K4K 4K0K ~4K9K9E4E 4E0E",  // B
                                                   "~8O6Q2Q0N0H2E6E8G",                     // C
                                                   "0E0Q3Q ~3Q8Q8M8I8E3E 3E0E",             // D
                                                   "7Q0Q0E7E 0K5K",                         // E
                                                   "7Q0Q0E 0K5K",                           // F
                                                   "~8O6Q2Q0N0H2E6E8G 8G8J5J",              // G
                                                   "0E0Q 8E8Q 0K8K",                        // H
                                                   "0E4E 0Q4Q 2E2Q",                        // I
                                                   "5Q5H ~5H5E2E0E0H",                      // J
                                                   "0E0Q 7Q0I 2K7E",                        // K
                                                   "0Q0E6E",                                // L
                                                   "0E0Q4I8Q8E",                            // M
                                                   "0E0Q7E7Q",                              // N
                                                   "@2E0H0N2Q6Q8N8H6E",                     // O
                                                   "0E0Q4Q ~4Q9Q9J4J 4J0J",                 // P
                                                   "@2E0H0N2Q6Q8N8H6E 5H8D",                // Q
                                                   "0E0Q4Q ~4Q9Q9J4J 4J0J 4J8E",            // R
                                                   "~8O6Q2Q0P0L3K5K8J8F6E2E0G",             // S
                                                   "0Q8Q 4Q4E",                             // T
                                                   "0Q0I ~0I0E4E8E8I 8I8Q",                 // U
                                                   "0Q4E8Q",                                // V
                                                   "0Q2E4N6E8Q",                            // W
                                                   "0Q8E 8Q0E",                             // X
                                                   "0Q4K8Q 4K4E",                           // Y
                                                   "0Q7Q0E7E",                              // Z
                                                   "3Q0Q0C3C",                              // [
                                                   "0Q5D",                                  // backslash
                                                   "0Q3Q3C0C",                              // ]
                                                   "0M3Q6M",                                // ^
                                                   "0C7C",                                  // _
                                                   "0Q2N",                                  // `
                                                   "@2E0G0K2M4M6K6G4E 6M6E",                // a
                                                   "0Q0E @2E0G0K2M4M6K6G4E",                // b
                                                   "~6L4M2M0K0G2E4E6F",                     // c
                                                   "6Q6E @2E0G0K2M4M6K6G4E",                // d
                                                   "0I6I ~6I6K5M1M0K0G2E4E6F",              // e
                                                   "~5Q2Q2M 2M2E 0M4M",                     // f
                                                   "@2E0G0K2M4M6K6G4E 6M6D ~6D6A3A1A0B",    // g
                                                   "0Q0E ~0J1M6N6I 6I6E",                   // h
                                                   "0M0E 0P0Q",                             // i
                                                   "2M2D ~2D2A0A 2P2Q",                     // j
                                                   "0Q0E 5M0H 2J6E",                        // k
                                                   "0Q0E",                                  // l
                                                   "0M0E ~0J1M5N5I 5I5E ~5J6M9N9I 9I9E",    // m
                                                   "0M0E ~0J1M6N6I 6I6E",                   // n
                                                   "@2E0G0K2M4M6K6G4E",                     // o
                                                   "0M0A @2E0G0K2M4M6K6G4E",                // p
                                                   "6M6A @2E0G0K2M4M6K6G4E",                // q
                                                   "0M0E ~0J1M4M",                          // r
                                                   "~5L3M0M0I3I6I6E3E0F",                   // s
                                                   "2P2H ~2H2E5E 0M4M",                     // t
                                                   "0M0H ~0H0D5E6H 6M6E",                   // u
                                                   "0M3E6M",                                // v
                                                   "0M2E4K6E8M",                            // w
                                                   "0M6E 6M0E",                             // x
                                                   "0M3E 6M2A0A",                           // y
                                                   "0M6M0E6E",                              // z
                                                   "~3Q1Q2K0J 0J2I ~2I1C3C",                // {
                                                   "0Q0C",                                  // |
                                                   "~0Q2Q1K3J 3J1I ~1I2C0C",                // }
                                                   "~0I1L3J4H6K"};                          // ~
constexpr std::string_view kUnknown = "0E0Q6Q6E0E";
constexpr float kSpace = 5, kGap = 3.2f;

Point between(Point a, Point b, float t) { return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}; }

// A quadratic curve with `control` in the middle.
void add_arc(Point from, Point control, Point to, std::vector<Point>& out) {
  constexpr int kSteps = 4;
  for (int i = 1; i <= kSteps; ++i) {
    const float t = static_cast<float>(i) / kSteps;
    out.push_back(between(between(from, control, t), between(control, to, t), t));
  }
}

// Rounds the corners: from the middle of each side to the middle of the next one.
std::vector<Point> smooth(std::vector<Point> p, bool closed) {
  if (p.size() < 3) return p;
  if (closed) {
    const Point start = between(p.back(), p.front(), 0.5f);
    p.insert(p.begin(), start);
    p.push_back(start);
  }
  std::vector<Point> out{p.front()};
  for (std::size_t i = 1; i + 1 < p.size(); ++i) {
    const bool last = i + 2 == p.size();
    add_arc(out.back(), p[i], last ? p[i + 1] : between(p[i], p[i + 1], 0.5f), out);
  }
  return out;
}

std::vector<Point> line_of(std::string_view stroke) {
  const bool closed = stroke.front() == '@', curved = closed || stroke.front() == '~';
  if (curved) stroke.remove_prefix(1);
  std::vector<Point> points;
  for (std::size_t i = 0; i + 1 < stroke.size(); i += 2)
    points.push_back({static_cast<float>(stroke[i] - '0'), static_cast<float>(stroke[i + 1] - 'E')});
  return curved ? smooth(std::move(points), closed) : points;
}

}  // namespace

Glyph glyph_of(char character) {
  Glyph glyph;
  if (character == ' ') {
    glyph.advance = kSpace;
    return glyph;
  }
  const auto index = static_cast<std::size_t>(static_cast<unsigned char>(character)) - '!';
  std::string_view rest = index < kGlyphs.size() ? kGlyphs[index] : kUnknown;
  while (!rest.empty()) {
    const std::size_t size = std::min(rest.find(' '), rest.size());
    glyph.lines.push_back(line_of(rest.substr(0, size)));
    rest.remove_prefix(std::min(size + 1, rest.size()));
  }
  for (const auto& line : glyph.lines)
    for (const Point& p : line) glyph.advance = std::max(glyph.advance, p.x);
  glyph.advance += kGap;
  return glyph;
}

void draw_text(Image& image, Point at, std::string_view text, float height_px, Color color) {
  const float unit = height_px / 12, width_px = std::max(1.0f, 0.12f * height_px);
  for (const char character : text) {
    const Glyph glyph = glyph_of(character);
    for (const auto& line : glyph.lines)
      for (std::size_t i = 0; i + 1 < line.size(); ++i)
        draw_line(image, {at.x + unit * line[i].x, at.y - unit * line[i].y},
                  {at.x + unit * line[i + 1].x, at.y - unit * line[i + 1].y}, color, width_px);
    at.x += unit * glyph.advance;
  }
}

float text_width_px(std::string_view text, float height_px) {
  float units = 0;
  for (const char character : text) units += glyph_of(character).advance;
  return text.empty() ? 0 : (units - kGap) * height_px / 12;
}

}  // namespace onemap::render
