// Applies materials and lights, which an edit may change, to placed geometry. This is the second
// half of build_scene() and all of update_scene(). Private to this folder.
#pragma once

#include <vector>

#include "renderer/scene/build_scene.h"
#include "renderer/scene/scene.h"

namespace emberline {

class SceneUpdater {
 public:
  // The geometry of the description is not read, so it may come from copy_without_geometry(). All
  // four arguments must outlive the updater.
  SceneUpdater(Scene& scene, const SceneDescription& description, const SceneBuildOptions& options,
               LoadProgress& progress)
      : scene_(scene), description_(description), options_(options), progress_(progress) {}

  // Reuses the emitters and the environment of a scene of the same file in another pose. `from`
  // maps each mesh to its index in that scene, or to kNone. Call this first; `before` is not needed
  // after build_lights().
  static constexpr uint32_t kNone = ~0u;
  void reuse_from(const Scene& before, const std::vector<uint32_t>& from);
  // Compiles and assigns the materials. Throws InputError, leaving everything unchanged.
  void assign_materials();
  void find_solids();
  // Builds emitters, lights and environment with the assigned materials; call it after the BVH is
  // built. Unchanged parts are reused. Throws InputError for too many emitters.
  void build_lights();
  // Updates memory statistics and features; call it last.
  void update_memory_and_features();

 private:
  std::vector<bool> used_materials() const;
  void mark_editable_filters(scene_detail::Mesh& mesh, const MeshDescription& source) const;
  bool emitters_changed() const;
  std::vector<EmissiveTriangle> collect_emitters();
  void collect_emitters_of(uint32_t instance, std::vector<EmissiveTriangle>& triangles);
  const EmissiveTriangle* previous_emitters(uint32_t mesh) const;
  void reserve_lights(uint64_t count) const;
  PointLight place_light(const PunctualLightDescription& source) const;
  bool set_environment();
  void find_flush_emitters(const std::vector<EmissiveTriangle>& before);
  bool has_motion() const;
  void list_motion();
  void list_features(bool culls, bool masks, bool blends);

  Scene& scene_;
  const SceneDescription& description_;
  const SceneBuildOptions& options_;
  LoadProgress& progress_;
  std::unique_ptr<MaterialSet> previous_materials_;  // kept until the meshes' emission is compared
  std::vector<bool> emission_changed_;               // per mesh: whether its emission has changed
  const Scene* previous_scene_ = nullptr;            // see reuse_from()
  std::vector<uint32_t> previous_mesh_indices_;      // per mesh: its index in previous_scene_
  std::vector<uint32_t> previous_first_emitters_;    // per mesh: first emitter of one instance
};

}  // namespace emberline
