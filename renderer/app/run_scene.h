// The scene of a run's frames, which is loaded, decoded and built once; where an animation moves
// it, it is posed for each frame, and only what moves is built anew.
#pragma once

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/file_register.h"
#include "renderer/core/load_progress.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_description.h"
#include "renderer/description/scene_edits.h"
#include "renderer/frame/scene_file.h"
#include "renderer/output/render_options.h"
#include "renderer/output/report.h"
#include "renderer/scene/build_scene.h"
#include "renderer/scene/cryptomatte_ids.h"
#include "renderer/scene/light_groups.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/surface_roles.h"

namespace emberline {

class RunScene {
 public:
  // `frames`: more than one will be asked for.
  RunScene(const LoadLimits& limits, bool frames) : limits_(limits), frames_(frames) {}

  // For each frame, in this order. What throws in the first frame's is wrong with the scene.
  // Reads what the frame is made of; a scene that is there stays, but what an animation poses for
  // another time. With `fingerprints` it is known what was read.
  void load(const RenderOptions& options, bool fingerprints, LoadProgress& progress);
  void build(const RenderOptions& options, const SceneBuildOptions& build, LoadProgress& progress);
  // Throws InputError for files that have changed since their fingerprints were taken. Once a load.
  void check_inputs(const RenderOptions& options, LoadProgress& progress);

  bool failed() const { return failed_; }  // to be loaded or built the first time
  bool is_built() const { return scene_ && stands_; }
  const Scene& scene() const { return *scene_; }
  // What this frame looks through.
  CameraDescription camera(const RenderOptions& options) const;
  const LightGroups* groups() const { return groups_ ? &*groups_ : nullptr; }
  const CryptomatteIds* cryptomattes() const { return cryptomattes_ ? &*cryptomattes_ : nullptr; }
  const SurfaceRoles* roles() const { return roles_ ? &*roles_ : nullptr; }
  const nlohmann::json& inputs() const { return inputs_; }
  // What it reads. Throws UsageError where that would be overwritten.
  void register_inputs(FileRegister& files) const;
  void report(RenderReport& report) const;
  // How many warnings there were when it was built: those of the scene, and of every frame.
  size_t warnings() const { return warnings_; }

 private:
  // By the parts that a load reserves and nobody gives back: Embree does that for the BVH.
  using MemoryUse = std::array<uint64_t, 4>;

  void read(const RenderOptions& options, LoadProgress& progress);
  // What the file says at the options' time, but for the meshes that `held` names.
  void pose(const RenderOptions& options, const std::vector<uint64_t>& held,
            LoadProgress& progress);
  void repose(const RenderOptions& options, const SceneBuildOptions& build, LoadProgress& progress);
  void release();
  MemoryUse use() const;  // reserved now, and not before the load

  const LoadLimits& limits_;
  const bool frames_;
  bool begun_ = false, failed_ = false, was_built_ = false, checked_ = false;
  bool animated_ = false;       // another time may be another pose
  bool stands_ = false;         // scene_ is of that time
  std::optional<double> time_;  // that it is posed for
  MemoryUse before_ = {}, used_ = {};
  SceneEdits edits_;
  std::optional<SceneFile> file_;  // while there may be another pose
  std::optional<PosedMemory> posed_memory_;
  SceneDescription description_;  // until it is built
  std::unique_ptr<Scene> scene_;
  std::optional<LightGroups> groups_;
  std::optional<CryptomatteIds> cryptomattes_;
  std::optional<SurfaceRoles> roles_;
  CameraDescription camera_;  // without a turntable
  WorldBounds bounds_;        // for one
  nlohmann::json inputs_;     // fingerprints
  std::vector<NamedFile> files_;
  std::string edited_environment_;  // the file of --edits' own; empty: none
  CoverageReport coverage_;
  LoadRepairs repairs_;
  size_t warnings_ = 0;
};

}  // namespace emberline
