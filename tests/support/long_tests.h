// Some tests have a short and a long version, which differ in their sizes. By default, tests run
// their short version. ci/nightly.sh sets EMBERLINE_LONG_TESTS=1, which makes them run their long
// version.
#pragma once

#include <cstdlib>

namespace emberline::test {

// Returns whether the long versions run. Reads the environment variable when a test runs. The list
// of tests must not depend on the variable, because the build creates that list.
inline bool long_tests() {
  const char* value = std::getenv("EMBERLINE_LONG_TESTS");
  return value != nullptr && *value != '\0' && *value != '0';
}

// Returns a size for this run: a number of samples, seeds, rays or pixels.
template <typename T>
T long_or_short(T full, T brief) {
  return long_tests() ? full : brief;
}

}  // namespace emberline::test
