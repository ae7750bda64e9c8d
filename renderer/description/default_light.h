// Light for a scene that has none.
#pragma once

namespace emberline {

struct SceneDescription;

// Gives a description without any light a plain white environment, and a warning, unless it may be
// dark or everything placed is unlit. From then on it may be dark: calling it again does nothing.
void add_default_light(SceneDescription& description);

}  // namespace emberline
