#include <OpenImageIO/imageio.h>

#include <stdexcept>

#include "support/image_files.h"

namespace emberline::test {
namespace {

void write(const std::string& path, int width, int height, int channels,
           const std::vector<float>& texels) {
  const auto output = OIIO::ImageOutput::create(path);
  const OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::FLOAT);
  if (!output || !output->open(path, spec) ||
      !output->write_image(OIIO::TypeDesc::FLOAT, texels.data()) || !output->close()) {
    throw std::runtime_error("cannot write " + path);
  }
}

std::vector<BytePicture> read(const std::string& path) {
  const auto input = OIIO::ImageInput::open(path);
  if (!input) throw std::runtime_error(path + ": " + OIIO::geterror());
  std::vector<BytePicture> pictures;
  for (int i = 0; input->seek_subimage(i, 0); ++i) {
    const OIIO::ImageSpec& spec = input->spec();
    BytePicture picture{spec.width, spec.height, spec.nchannels, {}};
    picture.values.resize(size_t(spec.width) * size_t(spec.height) * size_t(spec.nchannels));
    if (!input->read_image(i, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, picture.values.data())) {
      throw std::runtime_error(path + ": " + input->geterror());
    }
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

}  // namespace

const ImageFiles emberline_test_image_files{write, read};

}  // namespace emberline::test
