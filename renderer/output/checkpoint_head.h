// The JSON head of a checkpoint. It lists everything that the frame's bits depend on, for
// comparison, and the machine and the paths of the input files, for messages.
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
// what loading them would throw.
nlohmann::json input_fingerprints(const FrameSettings& settings, LoadProgress& progress);

// Remembers the files that a scene was loaded from, with their size and time, so that their
// fingerprints can be computed later, at the first save.
class LoadedFiles {
 public:
  LoadedFiles() = default;
  // Records the files named by the settings; call before they are read. Throws InputError.
  LoadedFiles(const FrameSettings& settings, const LoadProgress& progress);
  // Adds the files named by the scene description.
  void add(const std::vector<NamedFile>& files);

  // Returns input_fingerprints() of the loaded files. Throws InputError if a file has been replaced
  // or its size or time has changed. The edits file and the files that it names are checked only if
  // `settings` still has edits.
  nlohmann::json fingerprints(const FrameSettings& settings, LoadProgress& progress) const;

 private:
  void check(const FrameSettings& settings) const;

  std::vector<NamedFile> files_, edit_files_;
};

// Returns the head for a frame. `plan` determines the channels.
nlohmann::json checkpoint_head(const RenderOptions& options, const RenderPlan& plan,
                               const SceneLayers& layers, const nlohmann::json& inputs);
// Returns all settings in a head, including those that do not affect the bits, but not the paths of
// input files. Throws an InputError that names `place` if the head is invalid.
FrameSettings settings_of(const nlohmann::json& head, const std::string& place);
// Returns the text `name` from the head's `part`, which is "files" (paths by setting) or "machine".
// Empty if absent.
std::string find_text(const nlohmann::json& head, const char* part, const char* name);

// Lists the differences that prevent the frame `now` from resuming the checkpoint `then`, in a few
// words each; empty if the result is bit-identical. Settings in `ignored` may differ. `then` may be
// arbitrary JSON.
std::vector<std::string> differences(const nlohmann::json& now, const nlohmann::json& then,
                                     std::initializer_list<std::string_view> ignored = {});
// Like differences(), but compares only the processor maker and the Embree version, because
// rounding may depend on them.
std::vector<std::string> machine_differences(const nlohmann::json& now, const nlohmann::json& then);

}  // namespace emberline
