// Edits to begin with, for people to change.
#pragma once

#include "renderer/description/scene_edits.h"

namespace emberline {

// Edits that name every light, material and the environment with its present values, so that they
// change no bit of a frame. A value that an edit cannot restore exactly is left out, for example an
// attenuation distance of infinity, and so is the interior of thin-walled materials.
//
// `scene` is as apply({}, scene) leaves it, with its default light and material.
SceneEdits edits_template(const SceneDescription& scene);

}  // namespace emberline
