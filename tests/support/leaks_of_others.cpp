// For programs that load OpenNI2's drivers in a build with AddressSanitizer: the drivers leak a little whenever they
// are unloaded, which is not ours to mend. A library that was unloaded has no name in a report any more, so here none
// is, and leaks with one of these names on their stack are left out.
#if defined(__SANITIZE_ADDRESS__)
extern "C" {
int dlclose(void* /*library*/) { return 0; }
const char* __lsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier): the sanitizer's name
  return "leak:libOpenNI2\nleak:libPS1080\nleak:libPSLink\nleak:libOniFile\nleak:libDummyDevice\n";
}
}
#endif
