// Under AddressSanitizer and ThreadSanitizer programs are slower and larger.
#pragma once

namespace emberline::test {

// Times are stretched by this, and bounds on memory not held.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr double kSlower = 10.0;
#else
inline constexpr double kSlower = 1.0;
#endif
inline constexpr bool kSanitized = kSlower > 1.0;

}  // namespace emberline::test
