// A scope guard that makes the current thread flush denormals to zero, since arithmetic on
// denormals is many times slower. Render workers and all code that computes pixels from a film use
// it, so that pixels do not depend on the driver.
#pragma once

#if defined(__x86_64__) || defined(_M_X64)
#include <immintrin.h>
#endif

namespace emberline {

class FlushDenormals {
 public:
#if defined(__x86_64__) || defined(_M_X64)
  // Sets flush-to-zero and denormals-are-zero, which are bits 15 and 6 of MXCSR (Intel SDM, section
  // 10.2.3).
  FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040u); }
  ~FlushDenormals() { _mm_setcsr(saved_); }
#else
  FlushDenormals() {}
  ~FlushDenormals() {}
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  [[maybe_unused]] unsigned saved_ = 0;
};

}  // namespace emberline
