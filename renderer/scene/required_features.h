// What of renderer/core/features.h a scene asks for.
#pragma once

#include "renderer/scene/scene_description.h"

namespace emberline {

// Throws InputError that names what the scene needs and this program was built without. The program
// that people run was built with everything: there this does nothing.
void require_features(const SceneDescription& scene);

}  // namespace emberline
