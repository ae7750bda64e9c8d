// The directional albedo of a GGX reflection lobe, from tables, for energy compensation.
//
// With F = 1, a single-scattering lobe returns the fraction E(mu, alpha) < 1 of the light. B(mu,
// alpha) is the lobe's Schlick part, the integral of the lobe times (1 - v.h)^5. With Fresnel
// reflectance F0 at normal incidence, the lobe's albedo is then F0 E + (1 - F0) B (the split sum of
// Karis 2013, "Real Shading in Unreal Engine 4"). The lobe is isotropic GGX with height-correlated
// Smith masking.
//
// The tables contain two quantities: the loss 1 - E, and B - (1 - mu)^5 E. Both are smooth in
//   x = sqrt((1 + 2 alpha) mu / (mu + 2 alpha)),  y = sqrt(alpha).
// For small alpha, both quantities are functions of mu / alpha, so a grid in mu alone would miss
// their changes below mu = alpha. With 40 x 64 nodes and bilinear interpolation, the errors in E
// and in B are below 6e-4 for all mu and for every alpha in [kMirrorAlpha, 1] (measured against
// quadrature; unit test SpecularAlbedo).
//
// The tables are built once, at first use or in prepare(), in 6 to 13 ms. The build is
// deterministic and thread-safe.
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

// A view of the tables at one alpha. It is cheap to copy and valid until the program ends.
class SpecularAlbedo {
 public:
  // The default is a mirror: E = 1, B = (1 - mu)^5.
  SpecularAlbedo() = default;
  // `roughness` is glTF's, in [0, 1]; alpha = roughness^2. An alpha below kMirrorAlpha means a
  // mirror.
  explicit SpecularAlbedo(float roughness);
  // Builds the tables if needed, so that the first hit does not wait for them.
  static void prepare() { (void)tables(); }

  struct Value {
    float loss;     // 1 - E, in [0, 1]
    float schlick;  // B, in [0, 1]
  };
  [[gnu::always_inline]] Value at(float mu) const {  // mu in [0, 1]
    const float m = std::max(0.0f, 1.0f - mu);
    const float m5 = square(square(m)) * m;
    if (row_ == nullptr) return {0.0f, m5};
    const float x = std::sqrt(scale_ * mu / (mu + two_alpha_)) * float(kColumns - 1);
    const int i = std::min(int(x), kColumns - 2);
    const float f = x - float(i);
    const Node* a = row_ + i;
    const Node* b = a + kColumns;
    const float loss = lerp(lerp(a[0].loss, a[1].loss, f), lerp(b[0].loss, b[1].loss, f), y_);
    const float rest = lerp(lerp(a[0].rest, a[1].rest, f), lerp(b[0].rest, b[1].rest, f), y_);
    return {loss, fma(m5, 1.0f - loss, rest)};
  }

  // Cosine-weighted averages of at() over the hemisphere: 2 * integral of at(mu) mu dmu.
  float average_loss() const { return average_loss_; }
  float average_schlick() const { return average_schlick_; }

  bool is_mirror() const { return row_ == nullptr; }

 private:
  struct Node {
    float loss;  // 1 - E
    float rest;  // B - (1 - mu)^5 E
  };
  static constexpr int kColumns = 40;
  static constexpr int kRows = 64;
  // The averages depend on alpha only, so four nodes per row of the table are affordable.
  static constexpr int kAverages = 4 * (kRows - 1) + 1;
  struct Tables;
  static const Tables& tables();
  void select(const Tables& tables, float y);  // selects the rows around y in [0, 1]
  void integrate_average(double* loss, double* schlick) const;

  const Node* row_ = nullptr;  // two neighbouring rows of kColumns nodes
  float y_ = 0.0f;             // position between them
  float two_alpha_ = 0.0f;
  float scale_ = 1.0f;
  float average_loss_ = 0.0f;
  float average_schlick_ = 1.0f / 21.0f;  // 2 * integral of (1 - mu)^5 mu dmu
};

}  // namespace emberline
