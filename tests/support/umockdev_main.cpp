// The main program of tests on devices that umockdev plays. Where umockdev is not around it, it ends with 77 and says
// so: a skip, not a pass.
#include <gmock/gmock.h>

#include <cstdio>

#include "support/umockdev.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  if (onemap::test::inside_umockdev()) return RUN_ALL_TESTS();
  std::puts("skipped: umockdev-wrapper is not around this program (Debian: umockdev)");
  return 77;
}
