// Sizes of tests that have a short and a long version. ctest runs the short ones; ci/nightly.sh
// sets EMBERLINE_LONG_TESTS=1 and runs the long ones.
#pragma once

#include <cstdlib>

namespace emberline::test {

// Reads the variable when a test runs. The list of tests must not depend on it, because the build
// creates that list.
inline bool long_tests() {
  const char* value = std::getenv("EMBERLINE_LONG_TESTS");
  return value != nullptr && *value != '\0' && *value != '0';
}

// Chooses a number of samples, seeds, rays or pixels.
template <typename T>
T long_or_short(T full, T brief) {
  return long_tests() ? full : brief;
}

}  // namespace emberline::test
