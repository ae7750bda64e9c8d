#include "renderer/app/failure.h"

#include <new>

#include "renderer/core/errors.h"
#include "renderer/engine/worker_threads.h"

namespace emberline {

Failure failure_of(const std::exception& error) {
  if (const auto* ours = dynamic_cast<const EmberlineError*>(&error)) {
    return {ours->what(), ours->exit_code()};
  }
  if (dynamic_cast<const std::bad_alloc*>(&error)) {
    return {"out of memory; render a smaller frame (--size, --crop) or fewer textures",
            kExitRenderFailed};
  }
  return {message_of(error), kExitRenderFailed};
}

}  // namespace emberline
