#include "control/line_reader.hpp"

#include <gtest/gtest.h>

namespace onemap::control {
namespace {

// Every line that there is; one that was too long as "!".
std::vector<std::string> take(LineReader& reader) {
  std::vector<std::string> lines;
  for (LineReader::Line line; reader.next(line);) lines.push_back(line.too_long ? "!" : line.text);
  return lines;
}

using Lines = std::vector<std::string>;

TEST(LineReader, PutsLinesTogetherHoweverTheyArrive) {
  const std::string stream = "one\ntwo\r\n\nfour and more\n";
  for (std::size_t chunk = 1; chunk <= stream.size(); ++chunk) {
    LineReader reader(20);
    Lines all;
    for (std::size_t at = 0; at < stream.size(); at += chunk) {
      reader.add(stream.substr(at, chunk));
      for (auto& line : take(reader)) all.push_back(line);
    }
    EXPECT_EQ(all, (Lines{"one", "two", "", "four and more"})) << chunk;
    EXPECT_EQ(reader.held(), 0u);
  }
}

TEST(LineReader, ALongLineIsToldOnceAndTheNextIsGood) {
  LineReader reader(4);
  reader.add("1234\n12345");
  EXPECT_EQ(take(reader), (Lines{"1234", "!"})) << "told before its end is there";
  for (int i = 0; i < 1000; ++i) {
    reader.add(std::string(1000, 'x'));
    EXPECT_EQ(take(reader), Lines{});
    EXPECT_EQ(reader.held(), 0u) << "nothing is kept of it";
  }
  reader.add("\nok\n123456789\nok\n");
  EXPECT_EQ(take(reader), (Lines{"ok", "!", "ok"}));
}

TEST(LineReader, BinaryIsALineLikeAnyOther) {
  LineReader reader(100);
  reader.add(std::string("\0\xff\x01\n", 4));
  EXPECT_EQ(take(reader), (Lines{std::string("\0\xff\x01", 3)}));
}

}  // namespace
}  // namespace onemap::control
