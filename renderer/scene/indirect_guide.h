// Where indirect light comes from, for each part of a scene's surfaces. Paths use it to choose
// directions (CosineGuide) and to decide whether to continue (Russian roulette by the expected
// light; Vorba & Krivanek 2016, "Adjoint-Driven Russian Roulette and Splitting").
//
// The surfaces are divided into cells by position and normal, with about equally many survey
// vertices each (Müller et al. 2017, "Practical Path Guiding", divides space in a similar way). A
// vertex does not keep the light that its own path found, which would be very noisy. Instead, the
// light along each surveyed ray is the mean radiance of the cell that the ray hits. This makes a
// small radiosity system, which a few iterations solve (Dahm & Keller 2017, "Learning Light
// Transport the Reinforced Way"). Therefore a small number of rays is enough, and a cell learns of
// a distant light even if no path leads from the cell to the light.
//
// Radiance values are luminances. Immutable once built; thread-safe.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/core/vector.h"
#include "renderer/shading/lobes/cosine_guide.h"

namespace emberline {

// A surface point of a survey path. The vertices of a path are adjacent, beginning at the camera.
struct SurveyVertex {
  // The result of tracing the ray that leaves the vertex. After kSurface, the path's next vertex
  // follows.
  enum class Next : uint8_t { kUnknown, kSurface, kNothing };
  static constexpr float kMaxLight = 1e30f;  // greater light is taken for this

  Vec3f position;                   // internal space
  uint8_t orientation = 0;          // IndirectGuide::orientation_of() the shading normal
  uint8_t bin = 0;                  // of the ray's direction, if is_diffuse
  bool is_first : 1 = false;        // the first vertex of its path with albedo > 0
  bool samples_lights : 1 = false;  // false at the depth limit
  bool is_diffuse : 1 = false;  // the ray left the surface in a direction that a guide can choose
  Next next = Next::kUnknown;
  // Albedo of a surface that a guide serves (SurfaceBsdf::can_be_guided()); 0 for others.
  float albedo = 0.0f;
  float emitted = 0.0f;    // emitted towards the path's previous vertex, times the MIS weight
  float direct = 0.0f;     // light samples, scattered towards the previous vertex
  float weight = 0.0f;     // BSDF x cosine / pdf of the ray
  float incoming = -1.0f;  // light along the ray; -1 if unknown. Set by the survey for kNothing.
};

struct GuideCell {
  CosineGuide directions;
  // Mean over the cell of the irradiance / pi from light samples, and from all other light.
  float direct = 0.0f, indirect = 0.0f;
};

class IndirectGuide {
 public:
  // Builds a guide from survey paths; sets `incoming` of their vertices. The result does not depend
  // on the number of threads. Uses all threads.
  explicit IndirectGuide(std::vector<SurveyVertex>& vertices);
  // An upper bound on the memory of a guide, and of what building it takes.
  static uint64_t bytes(uint64_t vertices);

  // Returns the cell of a surface point, or null if the survey found no surface with a similar
  // normal. `normal` is the shading normal on the viewer's side.
  const GuideCell* find(const Vec3f& position, const Vec3f& normal) const {
    int32_t node = roots_[orientation_of(normal)];
    while (node >= 0) {
      const Node& at = nodes_[size_t(node)];
      node = at.children[position[at.axis] >= at.split];
    }
    return node == kNothing ? nullptr : &cells_[size_t(kFirstCell - node)];
  }

  // The normal's largest component and its sign, and the sign of z, at which local shading frames
  // are discontinuous (ShadingFrame::from_normal()).
  static constexpr int kOrientations = 12;
  static uint8_t orientation_of(const Vec3f& normal) {
    const float x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
    const int axis = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    return uint8_t(axis * 4 + std::signbit(normal[axis]) * 2 + std::signbit(normal.z));
  }

  // The fraction of the light at the surfaces that the camera sees that other surfaces reflect.
  double indirect_fraction() const { return indirect_fraction_; }
  bool empty() const { return cells_.empty(); }
  std::string describe() const;  // for the report

 private:
  static constexpr int32_t kNothing = -1, kFirstCell = -2;  // other negative numbers are cells
  struct Node {
    float split;
    int32_t axis;
    std::array<int32_t, 2> children;
  };
  std::array<int32_t, kOrientations> roots_;
  std::vector<Node> nodes_;
  std::vector<GuideCell> cells_;
  double indirect_fraction_ = 0;

  friend class IndirectGuideBuilder;
};

}  // namespace emberline
