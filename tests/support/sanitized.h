// Programs are slower and larger under AddressSanitizer and ThreadSanitizer.
#pragma once

namespace emberline::test {

// With a sanitizer, tests multiply their time limits by kSanitizerSlowdown and skip limits on
// memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr double kSanitizerSlowdown = 10.0;
#else
inline constexpr double kSanitizerSlowdown = 1.0;
#endif
inline constexpr bool kSanitized = kSanitizerSlowdown > 1.0;

}  // namespace emberline::test
