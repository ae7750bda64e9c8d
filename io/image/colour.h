// Finds the colour of an image by the names of its channels: an EXR may hold depth, normals and
// other layers beside its colour, or its colour in a layer.
#pragma once

#include <string>
#include <vector>

namespace emberline {

// A part of a multi-part EXR; other images have none.
struct ImagePart {
  std::string name;
  std::vector<std::string> channels;
  int first = -1;     // its first channel among the image's; -1: the part is not read
  bool cube = false;  // the faces of a cube, as the EXR's attribute `envmap` says
};

// Channels that stand together.
struct ColourChannels {
  int first = 0, count = 0;  // R, G and B, or one of grey
  bool has_alpha = false;    // A follows
  int end() const { return first + count + (has_alpha ? 1 : 0); }
};

// R, G and B without a layer; else those of the only layer that has them; else Y. Throws
// InputError that lists what there is, where that leaves nothing or a choice, and for
// luminance-chroma. `parts` may be empty.
ColourChannels find_colour(const std::vector<std::string>& channels,
                           const std::vector<ImagePart>& parts, const std::string& place);

// Whether the channel is of a part that holds the faces of a cube.
bool is_cube_map(const std::vector<ImagePart>& parts, int channel);

}  // namespace emberline
