// Edits that users can start from.
#pragma once

#include "renderer/description/scene_edits.h"

namespace emberline {

// Returns edits of every light, every material and the environment. They contain the present
// values, so applying them changes no bit of a frame. Leaves out values that an edit cannot
// reproduce exactly, such as an attenuation distance of infinity. Also leaves out the parameters of
// the interior for thin-walled materials, which have no interior.
//
// The caller must first call apply({}, scene), which adds the default light and the default
// material.
SceneEdits edits_template(const SceneDescription& scene);

}  // namespace emberline
