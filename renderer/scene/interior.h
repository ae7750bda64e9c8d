// Tracks which solids contain a ray, and updates them when the ray crosses a face.
#pragma once

#include <cstdint>

#include "renderer/scene/scene.h"
#include "renderer/scene/solids.h"

namespace emberline {

// The list of solids that contain a point on a path. Does not allocate.
class Interior {
 public:
  // Maximum number of solids. Entering one more drops the solid that was entered first (but never
  // the medium).
  static constexpr int kLimit = 16;
  static constexpr uint32_t kNone = ~0u;

  Interior() {}  // leaves the array uninitialised

  bool empty() const { return count_ == 0; }
  // Returns the material of the solid that counts as the medium, or null outside all solids. Of two
  // closed solids, the one with priority counts (Solids::has_priority). If either of them is open,
  // the one that was entered later counts.
  const Material* medium() const { return medium_; }
  // Returns the instance of the solid that counts as the medium, or kNone.
  uint32_t instance() const { return instance_; }

  // Returns false if the list was full, so that a solid was dropped.
  bool enter(const Scene& scene, uint32_t instance) {
    if (count_ > 0) return enter_nested(scene, instance);
    entered_[count_++] = instance_ = instance;
    medium_ = &scene.material_of(instance);
    return true;
  }
  // Leaves a solid. If this instance was never entered, leaves another one in its place. For a
  // closed instance, this is an entered part of the same body; if there is none, the list stays as
  // it is. For an open instance, it is the last entered solid with the same material, because a
  // solid may consist of several open meshes; if there is none, it is the medium.
  void leave(const Scene& scene, uint32_t instance) {
    if (count_ != 1 || instance_ != instance) return leave_nested(scene, instance);
    count_ = 0;
    instance_ = kNone;
    medium_ = nullptr;
  }

 private:
  bool enter_nested(const Scene& scene, uint32_t instance);
  void leave_nested(const Scene& scene, uint32_t instance);
  bool has_priority(const Scene& scene, uint32_t a, uint32_t b) const;
  void remove(const Scene& scene, int place);
  void update_medium(const Scene& scene);

  const Material* medium_ = nullptr;
  uint32_t instance_ = kNone;
  int count_ = 0;
  uint32_t entered_[kLimit];  // in order of entry
};

// The solid faces that a ray crosses at a hit. There may be several faces if they coincide, such as
// those of a liquid and its glass. There is no face if the solid is so flat that its own faces
// coincide. If a surface without an interior lies in the face, such as the table under a glass, the
// ray hits that surface instead.
class SolidCrossing {
 public:
  // Faces coincide with the hit face if they lie within this multiple of its error bound.
  static constexpr float kReach = 4.0f;

  SolidCrossing(const Scene& scene, const SurfaceInteraction& surface, const SurfaceHit& hit,
                const Ray& ray, CoverageKey coverage_key)
      : offset_(surface.offset) {
    faces_[0].hit = hit;
    faces_[0].is_exit = dot(ray.direction, surface.geometric_normal) > 0.0f;
    const Solids* solids = scene.solids();
    if (solids && solids->may_coincide(hit.instance, hit.primitive)) {
      find_coincident_faces(scene, surface, ray, coverage_key);
    }
  }

  // Changes the interior on the near side of the faces into that on the far side. Returns false if
  // the interior's list was full.
  bool cross(const Scene& scene, Interior* interior) const {
    for (const CrossedFace& face : *this) {
      if (face.is_exit) interior->leave(scene, face.hit.instance);
    }
    bool fits = true;
    for (const CrossedFace& face : *this) {
      if (!face.is_exit) fits = interior->enter(scene, face.hit.instance) && fits;
    }
    return fits;
  }
  // Returns the one of the coincident faces that scatters light: the face of the solid that has
  // priority among the solids on the near and the far side.
  const SurfaceHit& visible_face(const Scene& scene, const Interior& near,
                                 const Interior& far) const {
    return count_ == 1 ? faces_[0].hit : priority_face(scene, near, far);
  }
  // Returns the offset from the surface that puts a ray's origin beyond all of the faces.
  float offset() const { return offset_; }
  // Returns whether the ray leaves the solid that was hit.
  bool is_exit() const { return faces_[0].is_exit && !is_flat_; }
  // Returns the surface on which the ray ends here, or null.
  const SurfaceHit* surface() const { return has_surface_ ? &surface_ : nullptr; }
  const CrossedFace* begin() const { return faces_ + (is_flat_ ? 1 : 0); }
  const CrossedFace* end() const { return faces_ + count_; }
  bool empty() const { return begin() == end(); }

 private:
  static constexpr size_t kLimit = 8;
  void find_coincident_faces(const Scene& scene, const SurfaceInteraction& surface, const Ray& ray,
                             CoverageKey coverage_key);
  const SurfaceHit& priority_face(const Scene& scene, const Interior& near,
                                  const Interior& far) const;

  union {
    CrossedFace faces_[kLimit];  // the face that was hit comes first; only the first count_ are set
  };
  size_t count_ = 1;
  bool is_flat_ = false;  // if true, the ray leaves the solid at the point where it enters
  bool has_surface_ = false;
  SurfaceHit surface_;
  float offset_;
};

}  // namespace emberline
