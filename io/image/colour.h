// Finds an image's colour channels by name. An EXR may hold depth, normals and other layers besides
// its colour, or may have its colour in a layer.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace emberline {

// A part of a multi-part EXR. Other images have no parts.
struct ImagePart {
  std::string name;
  std::vector<std::string> channels;
  int first = -1;     // index of the part's first channel in the image; -1: the part is not read
  bool cube = false;  // whether the part holds the faces of a cube (EXR attribute `envmap`)
};

// The colour channels of an image. They are consecutive.
struct ColourChannels {
  int first = 0, count = 0;  // R, G and B, or one grey channel
  bool has_alpha = false;    // whether A follows them
  int end() const { return first + count + (has_alpha ? 1 : 0); }
};

// Chooses R, G and B that are outside any layer. If there are none, chooses the only layer that has
// R, G and B. If there is no such layer, chooses Y. Throws InputError for luminance-chroma images,
// and if there is no candidate (lists the channels) or more than one (lists the layers). `parts`
// may be empty. `remedy` tells the user what to do if there are several candidates.
ColourChannels find_colour(const std::vector<std::string>& channels,
                           const std::vector<ImagePart>& parts, const std::string& place,
                           std::string_view remedy = "save one of them as a separate file");

// Channels that belong together.
struct ImageLayer {
  std::string name;           // "albedo"; "RGBA" for channels without a layer
  std::vector<int> channels;  // indices of R, G, B; of X, Y and maybe Z; of U, V; or of one channel
  int alpha = -1;             // index; -1: none
  bool has_colour = false;    // whether `channels` are R, G and B

  bool is_number() const { return channels.size() == 1; }
};

// Returns all layers that can be read, in the file's order. A channel that is neither a colour nor
// a coordinate is a layer by itself: "samples", "denoised.error".
std::vector<ImageLayer> image_layers(const std::vector<std::string>& channels,
                                     const std::vector<ImagePart>& parts);

// Returns the layer, channel or part with this name, or nullopt if there is none. "RGB" and "RGBA"
// name the same layer. Throws InputError for a part that is not read.
std::optional<ImageLayer> try_find_layer(const std::vector<std::string>& channels,
                                         const std::vector<ImagePart>& parts,
                                         const std::string& name, const std::string& place);
// Like try_find_layer(), but if there is no such layer, throws a UsageError that lists the layers,
// with the nearest names first.
ImageLayer find_layer(const std::vector<std::string>& channels, const std::vector<ImagePart>& parts,
                      const std::string& name, const std::string& place);

// Whether the channel belongs to a part that holds the faces of a cube.
bool is_cube_map(const std::vector<ImagePart>& parts, int channel);

}  // namespace emberline
