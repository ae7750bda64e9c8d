// Names, matrices and primaries of the working spaces.
#pragma once

#include <array>
#include <span>
#include <string>

#include "io/display/choices.h"
#include "renderer/core/colour_matrix.h"
#include "renderer/core/names.h"

namespace emberline {

std::span<const NamedValue<WorkingSpace>> working_space_table();

// These return OpenColorIO's own matrices, which adapt D65 to the ACES white (Bradford), so that
// grey stays grey. They return null for Rec. 709.
ToWorkingSpace to_working_space(WorkingSpace space);
ToWorkingSpace from_working_space(WorkingSpace space);

// x and y of red, green, blue and white, in the order of OpenEXR's header.
using Chromaticities = std::array<float, 8>;
Chromaticities chromaticities_of(WorkingSpace space);
// Returns the working space with these primaries, or kRec709 if there is none.
WorkingSpace working_space_of(const Chromaticities& chromaticities);
// Returns the matrix from linear colours with these primaries to Rec. 709, or null if the primaries
// are those of Rec. 709. White is adapted by Bradford's transform (ICC.1, annex E). Throws
// InputError at `place` if the primaries are degenerate.
ToWorkingSpace to_rec709(const Chromaticities& chromaticities, const std::string& place);

}  // namespace emberline
