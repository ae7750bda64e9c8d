// What a checkpoint says of its frame: all that its bits depend on, to be compared; where its files
// were, and which machine it is of, to be told.
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

// Fingerprints of all files that a frame is made of, for a head's "inputs"; reads them. Throws what
// loading them throws.
nlohmann::json input_fingerprints(const FrameSettings& settings, LoadProgress& progress);

// The files that a scene was loaded from, and their states then, which cost no reading:
// fingerprints can be taken later, when a frame is saved for the first time.
class LoadedFiles {
 public:
  LoadedFiles() = default;
  // Those that the settings name, before they are read. Throws InputError.
  LoadedFiles(const FrameSettings& settings, const LoadProgress& progress);
  // Those that the scene's description has.
  void add(const std::vector<NamedFile>& files);

  // input_fingerprints(), of what was loaded: throws InputError where one is another file by now,
  // or has another size or time. Edits count if the settings name them still.
  nlohmann::json fingerprints(const FrameSettings& settings, LoadProgress& progress) const;

 private:
  void check(const FrameSettings& settings) const;

  std::vector<NamedFile> files_, of_edits_;
};

// `plan` has the channels that are rendered.
nlohmann::json checkpoint_head(const RenderOptions& options, const RenderPlan& plan,
                               const SceneLayers& layers, const nlohmann::json& inputs);
// The settings in a head, those that decide no bits too; without the scene's files. Throws
// InputError that names `place`: anything may stand there.
FrameSettings settings_of(const nlohmann::json& head, const std::string& place);
// "files" has where the frame's files were, by their settings' names, "machine" what made it;
// empty: it does not say.
std::string text_in(const nlohmann::json& head, const char* part, const char* name);

// What keeps a frame of `now` from going on with a checkpoint of `then`, a few words each; nothing
// if its bits are the same. Settings in `but` may differ. Anything may stand in `then`.
std::vector<std::string> differences(const nlohmann::json& now, const nlohmann::json& then,
                                     std::initializer_list<std::string_view> but = {});
// The same of machine and libraries: bits may differ by rounding between kinds of processor.
std::vector<std::string> machine_differences(const nlohmann::json& now, const nlohmann::json& then);

}  // namespace emberline
