// A default light for scenes that have no light.
#pragma once

namespace emberline {

struct SceneDescription;

// Adds a plain white environment and warns if the description has no light. Adds nothing if all
// instances have unlit materials. Does nothing if `may_be_dark` is set; otherwise sets it, so that
// later calls do nothing.
void add_default_light(SceneDescription& description);

}  // namespace emberline
