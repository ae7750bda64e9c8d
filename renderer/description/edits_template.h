// Edits that users can start from.
#pragma once

#include "renderer/description/scene_edits.h"

namespace emberline {

// Returns edits of every light, every material and the environment. They have the present values,
// so applying them changes no bit of a frame. Leaves out values that an edit cannot reproduce
// exactly, such as an attenuation distance of infinity. Also leaves out the interior of thin-walled
// materials.
//
// The caller must first call apply({}, scene), which adds the default light and the default
// material.
SceneEdits edits_template(const SceneDescription& scene);

}  // namespace emberline
