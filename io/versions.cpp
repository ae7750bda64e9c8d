#include "io/versions.h"

#include <OpenColorIO/OpenColorIO.h>
#include <OpenEXR/OpenEXRConfig.h>
#include <OpenImageIO/oiioversion.h>

namespace emberline {

std::vector<std::pair<std::string, std::string>> io_library_versions() {
  return {{"openexr", OPENEXR_VERSION_STRING},
          {"openimageio", OIIO_VERSION_STRING},
          {"opencolorio", OCIO_NAMESPACE::GetVersion()}};
}

}  // namespace emberline
