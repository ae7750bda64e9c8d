#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "renderer/lights/environment_light.h"
#include "renderer/scene/geometry.h"

namespace emberline::scene_detail {

// Moves mesh arrays from one pose to the next. Unless commit() is called, the destructor moves them
// back and restores the environment's settings, which the next pose may have changed.
class PoseHandover {
 public:
  // `light` may be null.
  PoseHandover(std::vector<Mesh>& from, std::vector<Mesh>& to,
               const std::shared_ptr<EnvironmentLight>& light)
      : from_(from), to_(to), light_(light) {
    if (light_) adjustment_ = light_->adjustment();
  }
  PoseHandover(const PoseHandover&) = delete;
  PoseHandover& operator=(const PoseHandover&) = delete;
  ~PoseHandover() {
    if (light_) light_->adjust(adjustment_);
    for (const MovedMesh& t : moved_meshes_) {
      exchange(to_[t.to], from_[t.from]);
      from_[t.from].record = t.record;
      from_[t.from].bvh = t.bvh;
      if (!t.record) continue;
      t.record->mesh = &from_[t.from];
      t.record->instance = t.salt;
    }
  }

  void move_mesh(uint32_t from, uint32_t to) {
    const Mesh& mesh = from_[from];
    moved_meshes_.push_back(
        {from, to, mesh.record, mesh.bvh, mesh.record ? mesh.record->instance : 0});
    exchange(from_[from], to_[to]);
  }
  void commit() {
    moved_meshes_.clear();
    light_.reset();
  }

 private:
  struct MovedMesh {
    uint32_t from, to;
    std::shared_ptr<GeometryRecord> record;
    std::shared_ptr<const EmbreeScene> bvh;
    uint32_t salt;  // GeometryRecord::instance
  };
  static void exchange(Mesh& from, Mesh& to) {
    std::swap<ReusableMesh>(from, to);
    if (to.record) to.record->mesh = &to;
  }

  std::vector<Mesh>& from_;
  std::vector<Mesh>& to_;
  std::vector<MovedMesh> moved_meshes_;
  std::shared_ptr<EnvironmentLight> light_;
  EnvironmentAdjustment adjustment_;
};

}  // namespace emberline::scene_detail
