// A default light for scenes without one.
#pragma once

namespace emberline {

struct SceneDescription;

// Adds a plain white environment to a description without light, and warns. Does nothing if
// `may_be_dark` is set or if all instances have unlit materials. Sets `may_be_dark`, so that later
// calls do nothing.
void add_default_light(SceneDescription& description);

}  // namespace emberline
