// The errors of this program as those of its interface.
#pragma once

#include <new>

#include "renderer/api/emberline.h"
#include "renderer/core/errors.h"
#include "renderer/core/load_progress.h"

namespace emberline::api {

// Runs `work`, and throws its errors as those of this interface.
template <typename Work>
decltype(auto) translated(const Work& work) {
  try {
    return work();
  } catch (const emberline::UsageError& error) {
    throw UsageError(error.what());
  } catch (const emberline::InputError& error) {
    throw InputError(error.what());
  } catch (const EmberlineError& error) {
    throw RenderError(error.what());
  } catch (const Cancelled&) {
    throw Stopped("the load was stopped");
  } catch (const std::bad_alloc&) {
    throw RenderError("out of memory");
  }
}

// Throws the program's UsageError for values that the command's options refuse.
void check_resources(const Resources& resources);
// The same for a picture that the caller may have filled in; `place` says where.
void check_picture(const std::string& place, const Picture& picture);

}  // namespace emberline::api
