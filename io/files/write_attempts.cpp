#include "io/files/write_attempts.h"

#include <exception>
#include <new>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"

namespace emberline {

bool WriteAttempts::attempt(const std::string& path, const std::function<void()>& write) {
  try {
    write();
    written_.push_back(path);
    return true;
  } catch (const EmberlineError& error) {
    log_error(error.what());  // the message names the file
  } catch (const std::bad_alloc&) {
    log_error("cannot write " + path + ": out of memory");
  } catch (const std::exception& error) {
    log_error("cannot write " + path + ": " + error.what());
  }
  failed_.push_back(path);
  return false;
}

}  // namespace emberline
