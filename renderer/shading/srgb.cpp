#include "renderer/shading/srgb.h"

#include <cmath>
#include <cstddef>

namespace emberline {

double srgb_to_linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

namespace {

// Returns the decoded values of all codes of an integer format.
std::vector<float> decoded_codes(size_t count, double (*decode)(double)) {
  std::vector<float> table(count);
  for (size_t i = 0; i < count; ++i) table[i] = float(decode(double(i) / double(count - 1)));
  return table;
}

}  // namespace

const std::vector<float>& srgb8_table() {
  static const std::vector<float> table = decoded_codes(256, srgb_to_linear);
  return table;
}

const std::vector<float>& linear8_table() {
  static const std::vector<float> table = decoded_codes(256, [](double x) { return x; });
  return table;
}

const std::vector<float>& srgb16_table() {
  static const std::vector<float> table = decoded_codes(65536, srgb_to_linear);
  return table;
}

}  // namespace emberline
