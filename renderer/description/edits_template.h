// Edits that users can start from.
#pragma once

#include "renderer/description/scene_edits.h"

namespace emberline {

// Returns edits of every light, every material and the environment, with their present values, so
// that they change no bit of a frame. Values that an edit cannot restore exactly, such as an
// attenuation distance of infinity, and the interior of thin-walled materials are left out.
//
// Call apply({}, scene) first, which adds the default light and material.
SceneEdits edits_template(const SceneDescription& scene);

}  // namespace emberline
