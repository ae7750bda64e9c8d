#include "renderer/shading/srgb.h"

#include <cmath>
#include <cstddef>

namespace emberline {

double srgb_to_linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

const std::array<float, 256>& srgb8_table() {
  static const auto table = [] {
    std::array<float, 256> t;
    for (size_t i = 0; i < t.size(); ++i) t[i] = float(srgb_to_linear(double(i) / 255));
    return t;
  }();
  return table;
}

const std::array<float, 256>& linear8_table() {
  static const auto table = [] {
    std::array<float, 256> t;
    for (size_t i = 0; i < t.size(); ++i) t[i] = float(double(i) / 255);
    return t;
  }();
  return table;
}

const std::vector<float>& srgb16_table() {
  static const auto table = [] {
    std::vector<float> t(65536);
    for (size_t i = 0; i < t.size(); ++i) t[i] = float(srgb_to_linear(double(i) / 65535));
    return t;
  }();
  return table;
}

}  // namespace emberline
