// JSON values of the session's protocol (PROTOCOL.md): reads edits, writes scenes and pictures.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "renderer/description/scene_edits.h"
#include "renderer/session/listed_scene.h"
#include "renderer/session/session_picture.h"

namespace emberline {

// Applies an object of edits (without a version) to `before`: null resets a part to the file's; a
// material or light replaces the entry for the same item of `lists`; any other part replaces its
// predecessor. A camera may have a `matrix`. Throws InputError with `name`.
SceneEdits merge_json_edits(const nlohmann::json& changes, const std::string& name,
                            const SceneEdits& before, const SceneDescription& lists);

// Applies `edits` over `before` in the same way; parts without edits are unchanged.
SceneEdits merge_edits(const SceneEdits& edits, SceneEdits before, const SceneDescription& lists);

nlohmann::json protocol_json(const ListedScene& scene, const SceneEdits& edits);
// Does not include where the picture is stored.
nlohmann::json protocol_json(const SessionPicture& picture);

}  // namespace emberline
