// Tests which channels of an EXR are its colours, for environments, textures and pictures to
// compare.
#include "io/image/colour.h"

#include <gtest/gtest.h>

#include <cstring>

#include "io/image/input.h"
#include "renderer/app/commands.h"
#include "renderer/core/errors.h"
#include "renderer/output/rgb_file.h"
#include "support/encoded_images.h"

namespace emberline {
namespace {

using OIIO::ImageSpec;
using OIIO::TypeDesc;
using test::TempFolder;
using Names = std::vector<std::string>;

template <typename Read>
std::string message_of(const Read& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string rejection_message(const Names& channels) {
  return message_of([&] { find_colour(channels, {}, "place"); });
}

struct PartOfFile {
  std::string name;
  Names channels;
  std::vector<float> values;  // of each channel, in all pixels
  int width = 2, x = 0;
  std::string environment = "";  // may be "CubeFace Environment"
};

// Writes an EXR of one or several parts.
void write_parts(const std::string& path, const std::vector<PartOfFile>& parts,
                 TypeDesc::BASETYPE type = TypeDesc::FLOAT) {
  std::vector<ImageSpec> specs;
  for (const PartOfFile& part : parts) {
    ImageSpec spec(part.width, 1, int(part.channels.size()), type);
    spec.x = part.x;
    spec.full_width = parts.front().width;
    spec.channelnames = part.channels;
    if (!part.name.empty()) spec.attribute("oiio:subimagename", part.name);
    if (!part.environment.empty()) spec.attribute("textureformat", part.environment);
    specs.push_back(spec);
  }
  const auto output = OIIO::ImageOutput::create(path);
  bool done = specs.size() > 1 ? output->open(path, int(specs.size()), specs.data())
                               : output->open(path, specs.front());
  for (size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) done = done && output->open(path, specs[i], OIIO::ImageOutput::AppendSubimage);
    std::vector<float> pixels;
    for (int x = 0; x < parts[i].width; ++x) {
      pixels.insert(pixels.end(), parts[i].values.begin(), parts[i].values.end());
    }
    done = done && output->write_image(TypeDesc::FLOAT, pixels.data());
  }
  if (!done || !output->close()) throw std::runtime_error("cannot write " + path);
}

class ImageColour : public ::testing::Test {
 protected:
  // Returns the first pixel of the file, read as an environment.
  std::vector<float> sky(const std::vector<PartOfFile>& parts) const {
    write_parts(path_, parts);
    const auto image = read_environment(path_, nullptr);
    std::vector<float> pixel(3);
    std::memcpy(pixel.data(), image->texels.data(), 3 * sizeof(float));
    return pixel;
  }
  std::string refused_sky(const std::vector<PartOfFile>& parts) const {
    return message_of([&] { sky(parts); });
  }

  const TempFolder folder_;
  const std::string path_ = folder_ / "a.exr";
};

const std::vector<float> kSky = {1, 2, 3};

TEST_F(ImageColour, TheOnlyLayerWithRgbIsUsed) {
  EXPECT_EQ(sky({{"", {"Z", "sky.R", "sky.G", "sky.B"}, {50, 1, 2, 3}}}), kSky);
  EXPECT_EQ(
      sky({{"", {"sky.R", "sky.G", "sky.B", "sky.A", "N.X", "N.Y", "N.Z"}, {1, 2, 3, 9, 8, 8, 8}}}),
      kSky);
  // Blender and Nuke use these names.
  EXPECT_EQ(sky({{"",
                  {"View.Combined.R", "View.Combined.G", "View.Combined.B", "View.Depth.Z"},
                  {1, 2, 3, 50}}}),
            kSky);
  EXPECT_EQ(sky({{"", {"a.Z", "sky.red", "sky.green", "sky.blue"}, {50, 1, 2, 3}}}), kSky);
  EXPECT_EQ(sky({{"", {"r", "g", "b"}, {1, 2, 3}}}), kSky);
  // R, G and B without a layer take precedence.
  EXPECT_EQ(sky({{"", {"R", "G", "B", "a.R", "a.G", "a.B"}, {1, 2, 3, 7, 8, 9}}}), kSky);
}

TEST_F(ImageColour, NonColourChannelsAreListed) {
  EXPECT_EQ(rejection_message({"Z"}),
            "place: it has neither channels R, G and B nor a single channel Y; its channels are Z");
  EXPECT_EQ(rejection_message({"N.X", "N.Y", "N.Z", "Z"}),
            "place: it has neither channels R, G and B nor a single channel Y; its channels are "
            "N.X, N.Y, N.Z, Z");
  EXPECT_NE(rejection_message({"X", "Y", "Z"}), "no error");  // coordinates
  EXPECT_NE(rejection_message({"R", "G"}), "no error");
  EXPECT_NE(rejection_message({"a.R", "b.G", "c.B"}), "no error");
  const std::string many = rejection_message(Names(4000, "depth.Z"));
  EXPECT_LT(many.size(), 300u);
  EXPECT_NE(many.find("and 3988 more"), std::string::npos) << many;
  EXPECT_EQ(
      refused_sky({{"", {"Z"}, {50}}}),
      path_ + ": it has neither channels R, G and B nor a single channel Y; its channels are Z");
}

TEST_F(ImageColour, SeveralLayersAreListed) {
  EXPECT_EQ(rejection_message({"Z", "day.R", "day.G", "day.B", "night.R", "night.G", "night.B"}),
            "place: 2 layers have R, G and B; save one of them as a separate file: day, night");
}

TEST_F(ImageColour, GreyIsASingleY) {
  EXPECT_EQ(sky({{"", {"Y"}, {2}}}), (std::vector<float>{2, 2, 2}));
  EXPECT_EQ(sky({{"", {"A", "Y", "Z"}, {7, 2, 50}}}), (std::vector<float>{2, 2, 2}));
  EXPECT_EQ(sky({{"", {"R"}, {2}}}), (std::vector<float>{2, 2, 2}));
  for (const Names& channels : {Names{"BY", "RY", "Y"}, Names{"Y", "RY"}, Names{"sky.BY", "Y"}}) {
    EXPECT_NE(rejection_message(channels).find("luminance-chroma"), std::string::npos)
        << channels[0];
  }
}

TEST_F(ImageColour, PartsAreSearchedToo) {
  EXPECT_EQ(sky({{"depth", {"Z"}, {50}}, {"sky", {"R", "G", "B"}, {1, 2, 3}}}), kSky);
  EXPECT_EQ(sky({{"depth", {"Z"}, {50}}, {"sky", {"sky.R", "sky.G", "sky.B"}, {1, 2, 3}}}), kSky);
  // The first part does not hide a later part.
  EXPECT_EQ(
      refused_sky({{"day", {"R", "G", "B"}, {1, 2, 3}}, {"night", {"R", "G", "B"}, {4, 5, 6}}}),
      path_ +
          ": 2 layers have R, G and B; save one of them as a separate file: R, G, B of part day, "
          "R, G, B of part night");
  const PartOfFile narrow = {"sky", {"R", "G", "B"}, {1, 2, 3}, 1, 1};
  EXPECT_NE(refused_sky({{"depth", {"Z"}, {50}}, narrow})
                .find("part sky: this part differs from the first in size"),
            std::string::npos);
  EXPECT_NE(refused_sky({{"depth", {"Z"}, {50}}, {"more", {"Z", "N.X"}, {1, 2}}})
                .find("its channels are Z, Z of part more, N.X of part more"),
            std::string::npos);
}

TEST_F(ImageColour, CubeMapsAreRefused) {
  const std::string cube = "CubeFace Environment";
  for (const std::vector<PartOfFile>& parts :
       {std::vector<PartOfFile>{{"", {"R", "G", "B"}, {1, 2, 3}, 2, 0, cube}},
        std::vector<PartOfFile>{{"depth", {"Z"}, {50}},
                                {"sky", {"R", "G", "B"}, {1, 2, 3}, 2, 0, cube}}}) {
    EXPECT_NE(refused_sky(parts).find("found a cube map"), std::string::npos);
  }
  EXPECT_EQ(sky({{"", {"R", "G", "B"}, {1, 2, 3}, 2, 0, "LatLong Environment"}}), kSky);
}

// Integer channels next to the colours do not matter.
TEST_F(ImageColour, OtherLayersMayHaveAnyType) {
  ImageSpec spec(1, 1, 4, TypeDesc::HALF);
  spec.channelnames = {"R", "G", "B", "id"};
  spec.channelformats = {TypeDesc::HALF, TypeDesc::HALF, TypeDesc::HALF, TypeDesc::UINT32};
  test::write_image<float>(path_, spec, {1, 2, 3, 0});
  EXPECT_EQ(read_environment(path_, nullptr)->channels, 3);
}

TEST_F(ImageColour, TexturesTakeTheSameChannels) {
  const auto texel = [&](const Names& channels, const std::vector<float>& values) {
    write_parts(path_, {{"", channels, values}});
    const auto image = decode_image(test::read_bytes(path_), "place").image;
    std::vector<float> first(size_t(image->channels));
    std::memcpy(first.data(), image->texels.data(), first.size() * sizeof(float));
    return first;
  };
  EXPECT_EQ(texel({"Z", "sky.R", "sky.G", "sky.B"}, {50, 1, 2, 3}), kSky);
  EXPECT_EQ(texel({"R", "G", "B", "Z"}, {1, 2, 3, 50}), kSky);  // depth is not alpha
  EXPECT_EQ(texel({"sky.R", "sky.G", "sky.B", "sky.A"}, {1, 2, 3, 0.5f}),
            (std::vector<float>{2, 4, 6, 0.5f}));
  EXPECT_EQ(texel({"Y", "A"}, {1, 0.5f}), (std::vector<float>{2, 0.5f}));
  EXPECT_THROW(texel({"Z"}, {50}), InputError);
}

TEST(FindColour, CryptomatteIsNotAColour) {
  using Channels = std::vector<std::string>;
  const Channels matte = {"CryptoObject00.R", "CryptoObject00.G", "CryptoObject00.B",
                          "CryptoObject00.A"};
  EXPECT_THROW(find_colour(matte, {}, "a.exr"), InputError);
  const Channels sky = {
      "crypto_asset00.r", "crypto_asset00.g", "crypto_asset00.b", "sky.R", "sky.G", "sky.B"};
  EXPECT_EQ(find_colour(sky, {}, "a.exr").first, 3);
}

TEST(FindColour, ChannelsInBothCasesAreNamed) {
  try {
    find_colour({"R", "r", "G", "g", "B", "b"}, {}, "a.exr");
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("channels whose names differ only in case"),
              std::string::npos);
  }
}

TEST(FindLayer, NamesLayersChannelsAndParts) {
  const Names channels = {"red", "green", "blue", "Z",   "a.light.R", "a.light.G", "a.light.B",
                          "a.A", "v.x",   "v.y",  "n.V", "m.b",       "m.c"};
  std::vector<std::string> names;
  for (const ImageLayer& layer : image_layers(channels, {})) names.push_back(layer.name);
  EXPECT_EQ(names, (Names{"RGB", "Z", "a.light", "a", "v", "n", "m.b", "m.c"}));
  const auto found = [&](const char* name) { return find_layer(channels, {}, name, "f").channels; };
  EXPECT_EQ(found("RGBA"), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(found("a.light"), (std::vector<int>{4, 5, 6}));
  EXPECT_EQ(found("v"), (std::vector<int>{8, 9}));
  EXPECT_EQ(found("n"), (std::vector<int>{10}));
  EXPECT_EQ(found("a.light.G"), (std::vector<int>{5}));
  EXPECT_THROW(found(""), UsageError);
}

TEST(FindLayer, PartsThatAreNotReadAreRefused) {
  const Names channels = {"R", "G", "B", "A"};
  const std::vector<ImagePart> parts = {{"left", channels, 0}, {"right", channels, -1}};
  const ImageLayer left = find_layer(channels, parts, "left", "f");
  EXPECT_EQ(left.channels.size(), 3u);
  EXPECT_EQ(left.alpha, 3);
  EXPECT_NE(message_of([&] { find_layer(channels, parts, "right", "f"); }).find("separate file"),
            std::string::npos);
}

TEST_F(ImageColour, ComparedPicturesTakeTheSameChannels) {
  const auto read = [&](const std::vector<PartOfFile>& parts) {
    write_parts(path_, parts);
    const std::vector<float> rgb = read_rgb(path_, LoadProgress::none()).pixels.rgb;
    return std::vector<float>(rgb.begin(), rgb.begin() + 3);
  };
  EXPECT_EQ(read({{"", {"Z", "sky.R", "sky.G", "sky.B"}, {50, 1, 2, 3}}}), kSky);
  EXPECT_EQ(read({{"depth", {"Z"}, {50}}, {"sky", {"R", "G", "B"}, {1, 2, 3}}}), kSky);
  EXPECT_THROW(read({{"a", {"R", "G", "B"}, {1, 2, 3}}, {"b", {"R", "G", "B"}, {4, 5, 6}}}),
               InputError);
  EXPECT_THROW(read({{"", {"Y"}, {1}}}), InputError);
}

// A file of two parts is refused, because the output would lose one part, or use its colour for the
// other.
TEST_F(ImageColour, DenoiseReadsOnePicture) {
  const PartOfFile left = {"left", {"R", "G", "B"}, {1, 2, 3}},
                   right = {"right", {"R", "G", "B"}, {4, 5, 6}};
  write_parts(path_, {left, right});
  DenoiseOptions options;
  options.image = path_;
  options.outputs = {folder_ / "b.exr"};
  EXPECT_NE(message_of([&] { run_denoise(options); }).find("its part right differs"),
            std::string::npos);
}

}  // namespace
}  // namespace emberline
