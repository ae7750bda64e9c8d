// The working spaces: their names, matrices and primaries.
#pragma once

#include <array>
#include <span>
#include <string>

#include "io/display/choices.h"
#include "renderer/core/colour_matrix.h"
#include "renderer/core/names.h"

namespace emberline {

std::span<const NamedValue<WorkingSpace>> working_space_table();

// OpenColorIO's own matrices, with Bradford's adaptation of D65 to the white of ACES, so that grey
// is grey. Null for Rec. 709.
ToWorkingSpace to_working_space(WorkingSpace space);
ToWorkingSpace from_working_space(WorkingSpace space);

// x and y of red, green, blue and white, as OpenEXR's header has them.
using Chromaticities = std::array<float, 8>;
Chromaticities chromaticities_of(WorkingSpace space);
// Whose they are; those of Rec. 709 if of nobody here.
WorkingSpace space_of(const Chromaticities& chromaticities);
// From linear colours of any primaries to Rec. 709, white adapted by Bradford's transform (as
// ICC.1, annex E). Null if they are Rec. 709's. Throws InputError with the place for those that
// span no colours.
ToWorkingSpace to_rec709(const Chromaticities& chromaticities, const std::string& place);

}  // namespace emberline
