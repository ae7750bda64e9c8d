// A default light for scenes that have no light.
#pragma once

namespace emberline {

struct SceneDescription;

// Adds a plain white environment and warns if the description has no light. Adds nothing if
// `may_be_dark` is set or if the materials of all instances are unlit. Sets `may_be_dark`, so that
// later calls do nothing.
void add_default_light(SceneDescription& description);

}  // namespace emberline
