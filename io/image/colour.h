// Finds an image's colour channels by name: an EXR may hold depth, normals and other layers besides
// its colour, or have its colour in a layer.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace emberline {

// A part of a multi-part EXR; empty for other images.
struct ImagePart {
  std::string name;
  std::vector<std::string> channels;
  int first = -1;     // index of its first channel in the image; -1: the part is not read
  bool cube = false;  // holds the faces of a cube (EXR attribute `envmap`)
};

// The colour channels of an image, which are consecutive.
struct ColourChannels {
  int first = 0, count = 0;  // R, G and B, or one grey channel
  bool has_alpha = false;    // followed by A
  int end() const { return first + count + (has_alpha ? 1 : 0); }
};

// Chooses R, G and B outside any layer. Without them, chooses the only layer that has R, G and B;
// without such a layer, chooses Y. Throws InputError for luminance-chroma images, and if there is
// no candidate (lists the channels) or more than one (lists the layers). `parts` may be empty.
// `remedy` tells the user what to do about several candidates.
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

// Returns all layers that can be read, in the file's order. Each channel that is neither a colour
// nor a coordinate is a layer by itself: "samples", "denoised.error".
std::vector<ImageLayer> image_layers(const std::vector<std::string>& channels,
                                     const std::vector<ImagePart>& parts);

// Returns the layer, channel or part with this name; nullopt if there is none. "RGB" and "RGBA" are
// the same layer. Throws InputError for a part that is not read.
std::optional<ImageLayer> try_find_layer(const std::vector<std::string>& channels,
                                         const std::vector<ImagePart>& parts,
                                         const std::string& name, const std::string& place);
// Like try_find_layer(), but if there is none, throws a UsageError that lists the layers, nearest
// names first.
ImageLayer find_layer(const std::vector<std::string>& channels, const std::vector<ImagePart>& parts,
                      const std::string& name, const std::string& place);

// Whether the channel belongs to a part that holds the faces of a cube.
bool is_cube_map(const std::vector<ImagePart>& parts, int channel);

}  // namespace emberline
