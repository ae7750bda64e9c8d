// The one error of a KTX 2 that is damaged. For io/image/ktx2 alone.
#pragma once

#include <string>

#include "renderer/core/errors.h"

namespace emberline::ktx2 {

// `what` continues "the KTX 2 ...".
[[noreturn]] inline void throw_damaged(const std::string& place, const std::string& what) {
  throw InputError(place, "the image does not decode: the KTX 2 " + what);
}

}  // namespace emberline::ktx2
