// Reads and writes JSON values of the session's protocol (PROTOCOL.md): edits, scenes and pictures.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "renderer/description/scene_edits.h"
#include "renderer/session/listed_scene.h"
#include "renderer/session/session_picture.h"

namespace emberline {

// Applies a JSON object of edits (without a version) to `before`. A member that is null resets its
// values to the file's. An entry for a material or light replaces the entry in `before` for the
// same item of `lists`. Every other member of `changes` replaces the whole member of `before`. A
// camera may have a `matrix`. Throws InputError, whose message begins with `name`.
SceneEdits merge_json_edits(const nlohmann::json& changes, const std::string& name,
                            const SceneEdits& before, const SceneDescription& lists);

// Applies `edits` to `before` in the same way. Keeps what `edits` does not change.
SceneEdits merge_edits(const SceneEdits& edits, SceneEdits before, const SceneDescription& lists);

nlohmann::json protocol_json(const ListedScene& scene, const SceneEdits& edits);
// The result does not say where the picture is stored.
nlohmann::json protocol_json(const SessionPicture& picture);

}  // namespace emberline
