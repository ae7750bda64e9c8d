#include "renderer/scene/interior.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "renderer/scene/solids.h"

namespace emberline {

bool Interior::has_priority(const Scene& scene, uint32_t a, uint32_t b) const {
  const Solids* solids = scene.solids();
  return solids && solids->closed(a) && solids->closed(b) && solids->has_priority(a, b);
}

void Interior::update_medium(const Scene& scene) {
  instance_ = count_ > 0 ? entered_[0] : kNone;
  for (int i = 1; i < count_; ++i) {
    if (!has_priority(scene, instance_, entered_[i])) instance_ = entered_[i];
  }
  medium_ = count_ > 0 ? &scene.material_of(instance_) : nullptr;
}

void Interior::remove(const Scene& scene, int place) {
  std::copy(entered_ + place + 1, entered_ + count_, entered_ + place);
  --count_;
  update_medium(scene);
}

bool Interior::enter_nested(const Scene& scene, uint32_t instance) {
  const bool full = count_ == kLimit;
  if (full) remove(scene, entered_[0] == instance_ ? 1 : 0);
  entered_[count_++] = instance;
  update_medium(scene);
  return !full;
}

void Interior::leave_nested(const Scene& scene, uint32_t instance) {
  const auto remove_last = [&](const auto& matches) {
    for (int i = count_; i-- > 0;) {
      if (matches(entered_[i])) {
        remove(scene, i);
        return true;
      }
    }
    return false;
  };
  if (remove_last([&](uint32_t entered) { return entered == instance; })) return;
  const Solids* const solids = scene.solids();
  if (solids && solids->closed(instance)) {
    if (!solids->has_joined_parts()) return;
    const uint32_t body = solids->body(instance);
    remove_last([&](uint32_t entered) { return solids->body(entered) == body; });
    return;
  }
  const Material* own = &scene.material_of(instance);
  if (remove_last([&](uint32_t entered) { return &scene.material_of(entered) == own; })) return;
  remove_last([&](uint32_t entered) { return entered == instance_; });
}

void SolidCrossing::find_coincident_faces(const Scene& scene, const SurfaceInteraction& surface,
                                          const Ray& ray, CoverageKey coverage_key) {
  const Solids* solids = scene.solids();
  const SurfaceHit& hit = faces_[0].hit;
  is_flat_ = solids->is_flat(hit.instance);
  const float reach = kReach * surface.offset;
  const Vec3f along = faces_[0].is_exit ? surface.geometric_normal : -surface.geometric_normal;
  CrossedFace found[32];
  const size_t count = scene.faces_along(surface.position - along * reach, along, 2 * reach,
                                         ray.time, coverage_key, found);
  const auto body = [&](const CrossedFace& face) { return solids->body(face.hit.instance); };
  std::sort(found, found + count, [&](const CrossedFace& a, const CrossedFace& b) {
    return std::tuple(body(a), a.is_exit, a.hit.instance, a.hit.primitive) <
           std::tuple(body(b), b.is_exit, b.hit.instance, b.hit.primitive);
  });
  const uint32_t own = body(faces_[0]);
  for (size_t i = 0, next = 0; i < count && count_ < kLimit; i = next) {
    const uint32_t instance = found[i].hit.instance, here = body(found[i]);
    while (next < count && body(found[next]) == here) ++next;
    const bool is_same_side = found[i].is_exit == found[next - 1].is_exit;
    const Material& material = scene.material_of(instance);
    if (!material.is_solid()) {
      // FlushEmitters decides whether an emissive surface is visible.
      if (has_surface_ || material.is_emissive()) continue;
      has_surface_ = true;
      surface_ = found[i].hit;
    } else if (here != own && is_same_side && !solids->is_flat(instance)) {
      // Adds one face per solid: at an edge, a ray meets two faces of a solid, but crosses its
      // surface once or not at all.
      faces_[count_++] = found[i];
    }
  }
  if (count_ > 1 || has_surface_) offset_ = reach;
}

const SurfaceHit& SolidCrossing::priority_face(const Scene& scene, const Interior& near,
                                               const Interior& far) const {
  const Solids* const solids = scene.solids();
  uint32_t first = near.instance(), second = far.instance();
  if (first == Interior::kNone ||
      (second != Interior::kNone && solids->has_priority(second, first))) {
    std::swap(first, second);
  }
  for (const uint32_t instance : {first, second}) {
    if (instance == Interior::kNone) continue;
    for (const CrossedFace& face : *this) {
      if (solids->body(face.hit.instance) == solids->body(instance)) return face.hit;
    }
  }
  return faces_[0].hit;
}

}  // namespace emberline
