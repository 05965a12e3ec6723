#include "control/wrapped.hpp"

#include <gtest/gtest.h>

namespace onemap::control {
namespace {

TEST(Wrapped, LinesThatFitAreAsTheyWere) {
  for (const std::string text : {"", "\n", "one\n\n  two\n", "no end", "exactly ten"})
    EXPECT_EQ(wrapped(text, 11), text);
}

TEST(Wrapped, ALongLineGoesOnBelowItsBeginning) {
  EXPECT_EQ(wrapped("  one two three four\nfive\n", 12), "  one two\n  three four\nfive\n");
}

TEST(Wrapped, AnOptionGoesOnBelowWhatIsSaidOfIt) {
  EXPECT_EQ(wrapped("  --png FILE      write a picture of the map", 40),
            "  --png FILE      write a picture of the\n"
            "                  map");
}

TEST(Wrapped, AWordThatIsTooLongStaysWhole) {
  EXPECT_EQ(wrapped("a simulated:living-room?frames=300 b", 10), "a\nsimulated:living-room?frames=300\nb");
}

}  // namespace
}  // namespace onemap::control
