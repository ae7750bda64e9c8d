#include "io/image/versions.h"

#include <OpenColorIO/OpenColorIO.h>
#include <OpenEXR/OpenEXRConfig.h>
#include <OpenImageIO/oiioversion.h>
#include <jpeglib.h>
#include <png.h>

namespace emberline {

namespace {

std::string libjpeg_version() {
#ifdef LIBJPEG_TURBO_VERSION_NUMBER  // libjpeg-turbo; the number 2001005 means 2.1.5
  constexpr int kNumber = LIBJPEG_TURBO_VERSION_NUMBER;
  return std::to_string(kNumber / 1000000) + "." + std::to_string(kNumber / 1000 % 1000) + "." +
         std::to_string(kNumber % 1000) + " (turbo)";
#else
  return std::to_string(JPEG_LIB_VERSION);
#endif
}

}  // namespace

std::vector<std::pair<std::string, std::string>> io_library_versions() {
  return {{"openexr", OPENEXR_VERSION_STRING},
          {"openimageio", OIIO_VERSION_STRING},
          {"libpng", PNG_LIBPNG_VER_STRING},
          {"libjpeg", libjpeg_version()},
          {"opencolorio", OCIO_NAMESPACE::GetVersion()}};
}

}  // namespace emberline
