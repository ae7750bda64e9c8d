// What of a scene an edit may change, materials and lights, put onto geometry that is already
// placed: the second half of build_scene, and all of update_scene. Private to this folder.
#pragma once

#include <vector>

#include "renderer/scene/build_scene.h"
#include "renderer/scene/scene.h"

namespace emberline {

class SceneUpdater {
 public:
  // Of the description, the geometry is not looked at: an outline (scene_edits.h) will do. All
  // four outlive the updater.
  SceneUpdater(Scene& scene, const SceneDescription& description, const SceneBuildOptions& options,
               LoadProgress& progress)
      : scene_(scene), description_(description), options_(options), progress_(progress) {}

  // What a scene of the same file has found out about emitters, in another pose, and its
  // environment: `from` says of each mesh which of that scene's it was, or kNone. Before the rest;
  // from build_lights() on that scene is not needed any more.
  static constexpr uint32_t kNone = ~0u;
  void learn_from(const Scene& before, const std::vector<uint32_t>& from);
  // Compiles the materials and says of every mesh what it has of its own. Throws InputError, and
  // has then changed nothing.
  void assign_materials();
  // Throws Cancelled.
  void find_solids();
  // Emitters, lights and environment of those materials, after the BVH. What a scene already has
  // and has not changed stays. Throws InputError for too many emitters.
  void build_lights();
  // Memory and features, last.
  void update_memory_and_features();

 private:
  std::vector<bool> used_materials() const;
  void mark_editable_filters(scene_detail::Mesh& mesh, const MeshDescription& source) const;
  bool emitters_changed() const;
  std::vector<EmissiveTriangle> collect_emitters();
  void collect_emitters_of(uint32_t instance, std::vector<EmissiveTriangle>& triangles);
  const EmissiveTriangle* known_emitters(uint32_t mesh) const;
  void reserve_lights(uint64_t count) const;
  PointLight place_light(const PunctualLightDescription& source) const;
  bool set_environment();
  void find_flush_emitters(const std::vector<EmissiveTriangle>& before);
  bool anything_moves() const;
  void list_motion();
  void list_features(bool culls, bool masks, bool blends);

  Scene& scene_;
  const SceneDescription& description_;
  const SceneBuildOptions& options_;
  LoadProgress& progress_;
  std::unique_ptr<MaterialSet> previous_;  // kept while the meshes' emission is compared
  std::vector<bool> emission_changed_;     // per mesh: emits otherwise than it did
  const Scene* before_ = nullptr;          // see learn_from
  std::vector<uint32_t> known_from_;       // per mesh: the mesh there,
  std::vector<uint32_t> known_emitters_;   // and the first emitter of one of its instances
};

}  // namespace emberline
