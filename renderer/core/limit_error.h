// What a load may take is used up: the fault of all that was asked for, and not of the object that
// was being read. Who goes on without a broken object does not catch this.
#pragma once

#include "renderer/core/errors.h"

namespace emberline {

struct LimitError : InputError {
  using InputError::InputError;
};

}  // namespace emberline
