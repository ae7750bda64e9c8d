// Values of the session's protocol (PROTOCOL.md) as JSON: edits in, scenes and pictures out.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "renderer/description/scene_edits.h"
#include "renderer/session/listed_scene.h"
#include "renderer/session/shown_picture.h"

namespace emberline {

// `before` with the parts of an object of edits, without a version: a part that is null is the
// file's, one for a material or light takes the place of that for the same entry of `lists`, all
// others replace theirs. A camera may have a `matrix`. Throws InputError, with `name`.
SceneEdits merged_edits(const nlohmann::json& changes, const std::string& name,
                        const SceneEdits& before, const SceneDescription& lists);

// `edits` over `before`, likewise: parts that say nothing stay as they are.
SceneEdits laid_over(const SceneEdits& edits, SceneEdits before, const SceneDescription& lists);

nlohmann::json described(const ListedScene& scene, const SceneEdits& edits);
// But where it is to be found.
nlohmann::json described(const ShownPicture& picture);

}  // namespace emberline
