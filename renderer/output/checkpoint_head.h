// The JSON head of a checkpoint: everything its bits depend on, for comparison, and its files'
// paths and its machine, for messages.
#pragma once

#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/file_identity.h"
#include "renderer/core/load_progress.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/render_options.h"
#include "renderer/output/scene_layers.h"

namespace emberline {

// Reads all input files of a frame and returns their fingerprints for the head's "inputs". Throws
// what loading them throws.
nlohmann::json input_fingerprints(const FrameSettings& settings, LoadProgress& progress);

// The files that a scene was loaded from and their state at that time, recorded without reading
// them, so that fingerprints can be taken at the first save.
class LoadedFiles {
 public:
  LoadedFiles() = default;
  // Records the files named by the settings; call before they are read. Throws InputError.
  LoadedFiles(const FrameSettings& settings, const LoadProgress& progress);
  // Adds the files named by the scene description.
  void add(const std::vector<NamedFile>& files);

  // Returns input_fingerprints() of the loaded files. Throws InputError if a file was replaced or
  // its size or time changed since. The edits' files count only if the settings still name them.
  nlohmann::json fingerprints(const FrameSettings& settings, LoadProgress& progress) const;

 private:
  void check(const FrameSettings& settings) const;

  std::vector<NamedFile> files_, edit_files_;
};

// `plan` determines the channels.
nlohmann::json checkpoint_head(const RenderOptions& options, const RenderPlan& plan,
                               const SceneLayers& layers, const nlohmann::json& inputs);
// Returns the settings in a head, including those that decide no bits, without the scene's files.
// The head may be arbitrary JSON: throws InputError that names `place`.
FrameSettings settings_of(const nlohmann::json& head, const std::string& place);
// Returns a text of "files" (paths by setting) or "machine". Empty if absent.
std::string find_text(const nlohmann::json& head, const char* part, const char* name);

// Lists in a few words each what prevents a frame of `now` from resuming `then`; empty if the bits
// are the same. Settings in `ignored` may differ. `then` may be arbitrary JSON.
std::vector<std::string> differences(const nlohmann::json& now, const nlohmann::json& then,
                                     std::initializer_list<std::string_view> ignored = {});
// As differences(), for machine and libraries: bits may differ by rounding between processor
// makers.
std::vector<std::string> machine_differences(const nlohmann::json& now, const nlohmann::json& then);

}  // namespace emberline
