// A default light for scenes that have none.
#pragma once

namespace emberline {

struct SceneDescription;

// If the description has no light, adds a plain white environment and warns. Does not add it if
// `may_be_dark` is set or if the materials of all instances are unlit. Sets `may_be_dark`, so that
// later calls do nothing.
void add_default_light(SceneDescription& description);

}  // namespace emberline
