// The solids that a ray is inside of, and what a face does to them.
#pragma once

#include <cstdint>

#include "renderer/scene/scene.h"
#include "renderer/scene/solids.h"

namespace emberline {

// A list, as a value of a path. Nothing here allocates.
class Interior {
 public:
  // Solids at once; of more the ones that do not fill the place are forgotten first.
  static constexpr int kMost = 16;
  static constexpr uint32_t kNone = ~0u;

  Interior() {}  // leaves the list's memory as it is

  bool empty() const { return count_ == 0; }
  // The material that fills the place: that of the solid that precedes (Solids). Open solids have
  // no order; of these the one that was entered last fills it. Null outside of all solids.
  const Material* solid() const { return solid_; }
  // That solid's instance, or kNone.
  uint32_t instance() const { return filling_; }

  // False: the list was full.
  bool enter(const Scene& scene, uint32_t instance) {
    if (count_ > 0) return enter_another(scene, instance);
    entered_[count_++] = filling_ = instance;
    solid_ = &scene.material_of(instance);
    return true;
  }
  // A solid may be made of several open meshes: it is left by the face of another instance of its
  // material, too. An open solid that was never entered takes the one that fills the place with it;
  // a closed one changes nothing.
  void leave(const Scene& scene, uint32_t instance) {
    if (count_ != 1 || filling_ != instance) return leave_one(scene, instance);
    count_ = 0;
    filling_ = kNone;
    solid_ = nullptr;
  }

 private:
  bool enter_another(const Scene& scene, uint32_t instance);
  void leave_one(const Scene& scene, uint32_t instance);
  bool precedes(const Scene& scene, uint32_t a, uint32_t b) const;
  void remove(const Scene& scene, int place);
  void choose(const Scene& scene);

  const Material* solid_ = nullptr;
  uint32_t filling_ = kNone;
  int count_ = 0;
  uint32_t entered_[kMost];  // in order
};

// The faces of solids that a ray goes through where it meets one: several if faces coincide, as
// those of a liquid and of its glass; none of a solid so flat that its faces coincide. A surface
// that lies in the face, as the table on which a glass stands, is met in its place.
class SolidCrossing {
 public:
  // Coincident faces lie within so many bounds of the error of either.
  static constexpr float kReach = 4.0f;

  // `surface` and `hit` are what the ray met: a face of a solid.
  SolidCrossing(const Scene& scene, const SurfaceInteraction& surface, const SurfaceHit& hit,
                const Ray& ray, CoverageKey coverage_key)
      : offset_(surface.offset) {
    faces_[0].hit = hit;
    faces_[0].back = dot(ray.direction, surface.geometric_normal) > 0.0f;
    const Solids* solids = scene.solids();
    if (solids && solids->may_touch(hit.instance, hit.primitive)) {
      find_others(scene, surface, ray, coverage_key);
    }
  }

  // From the near to the far side. False: the list was full.
  bool cross(const Scene& scene, Interior* interior) const {
    for (const CrossedFace& face : *this) {
      if (face.back) interior->leave(scene, face.hit.instance);
    }
    bool room = true;
    for (const CrossedFace& face : *this) {
      if (!face.back) room = interior->enter(scene, face.hit.instance) && room;
    }
    return room;
  }
  // The face that scatters, of those that coincide: of the two solids that fill the sides, that of
  // the one that precedes.
  const SurfaceHit& seen_face(const Scene& scene, const Interior& near, const Interior& far) const {
    return count_ == 1 ? faces_[0].hit : preceding_face(scene, near, far);
  }
  // Rays that leave go as far from the surface as clears all of the faces.
  float offset() const { return offset_; }
  // The way leads out of the solid that was hit.
  bool back() const { return faces_[0].back && !through_flat_; }
  // The surface that ends the way here. Null: none.
  const SurfaceHit* surface() const { return has_surface_ ? &surface_ : nullptr; }
  const CrossedFace* begin() const { return faces_ + (through_flat_ ? 1 : 0); }
  const CrossedFace* end() const { return faces_ + count_; }
  bool empty() const { return begin() == end(); }

 private:
  static constexpr size_t kMost = 8;
  void find_others(const Scene& scene, const SurfaceInteraction& surface, const Ray& ray,
                   CoverageKey coverage_key);
  const SurfaceHit& preceding_face(const Scene& scene, const Interior& near,
                                   const Interior& far) const;

  union {
    CrossedFace faces_[kMost];  // the one that was hit comes first; set as far as they are met
  };
  size_t count_ = 1;
  bool through_flat_ = false;  // the solid that was hit is left where it is entered
  bool has_surface_ = false;
  SurfaceHit surface_;
  float offset_;
};

}  // namespace emberline
