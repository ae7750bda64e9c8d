// The JSON head of a checkpoint. It lists everything that the frame's bits depend on, so that heads
// can be compared. It also lists the machine and the paths of the input files, for messages.
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

// Returns the name under which "inputs" lists the file of the sample plan.
std::string plan_input_name();

// Remembers the files that a scene was loaded from, with their size and modification time, so that
// their fingerprints can be computed later.
class LoadedFiles {
 public:
  LoadedFiles() = default;
  // Records the files that the settings name. Call before these files are read. Throws InputError.
  LoadedFiles(const FrameSettings& settings, const LoadProgress& progress);
  // Adds the files named by the scene description.
  void add(const std::vector<NamedFile>& files);

  // Returns input_fingerprints() of the loaded files. Throws InputError if a file has been replaced
  // or if its size or modification time has changed. The edits file and the files that it names are
  // checked only if `settings` still has edits.
  nlohmann::json fingerprints(const FrameSettings& settings, LoadProgress& progress) const;

 private:
  void check(const FrameSettings& settings) const;

  std::vector<NamedFile> files_, edit_files_;
};

// Returns the head for a frame. `plan` determines the channels.
nlohmann::json checkpoint_head(const RenderOptions& options, const RenderPlan& plan,
                               const SceneLayers& layers, const nlohmann::json& inputs);
// Returns all settings in a head, including those that do not affect the bits. Paths of input files
// are left out, except that of the sample plan. Throws an InputError that names `place` if the head
// is invalid.
FrameSettings settings_of(const nlohmann::json& head, const std::string& place);
// Returns the text called `name` from the head's member `part`, which is "files" (paths by setting)
// or "machine". Returns "" if there is no such text.
std::string find_text(const nlohmann::json& head, const char* part, const char* name);

// Lists the differences that prevent the frame with the head `now` from resuming a checkpoint with
// the head `then`, each in a few words. The list is empty if the resumed frame will be
// bit-identical. Settings in `ignored` may differ. `then` may be arbitrary JSON.
std::vector<std::string> differences(const nlohmann::json& now, const nlohmann::json& then,
                                     std::initializer_list<std::string_view> ignored = {});
// Like differences(), but compares only the processor maker and the Embree version, because the
// rounding of results may depend on these two.
std::vector<std::string> machine_differences(const nlohmann::json& now, const nlohmann::json& then);

}  // namespace emberline
