// Default options of the sanitizers, which read them from these functions of the program.
//
// AddressSanitizer: Debian 12's libfastrtps.so frees its statistics objects with another class size than it allocated
// them with (a reader's: 64 and 56 bytes), all inside the library and harmless with glibc, which ignores the size.
// Without this option no program with a DDS writer survives its own end.
//
// ThreadSanitizer: libfastrtps.so is not instrumented and locks with calls of which the sanitizer sees only half, so
// that it reports unlocks of mutexes that were never locked, and lock orders derived from these.

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): the sanitizers require these names
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "new_delete_type_mismatch=0";
}

extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "mutex:libfastrtps.so\n"
         "deadlock:libfastrtps.so\n";
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)
