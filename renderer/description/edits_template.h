// Edits that users can start from.
#pragma once

#include "renderer/description/scene_edits.h"

namespace emberline {

// Returns edits of every light, every material and the environment that reproduce their present
// values, so that applying the edits changes no bit of a frame. It leaves out values that an edit
// cannot reproduce exactly, such as an attenuation distance of infinity, and the interior of
// thin-walled materials.
//
// Call apply({}, scene) first, which adds the default light and the default material.
SceneEdits edits_template(const SceneDescription& scene);

}  // namespace emberline
