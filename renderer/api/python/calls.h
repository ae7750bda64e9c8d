// Long calls from Python: they release the interpreter's lock (GIL), and Ctrl-C stops them.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <stop_token>
#include <string_view>
#include <utility>

namespace emberline::python {

namespace py = pybind11;

// A long call, as seen by the code that it runs.
class Call {
 public:
  virtual ~Call() = default;
  // Returns a token that requests a stop after an exception in Python. The result of `work` is then
  // discarded.
  virtual std::stop_token cancellation() const = 0;
  // Runs `work` with the GIL on the thread that called from Python, and waits until `work` has
  // ended. Does nothing after an exception in Python.
  virtual void run_in_python(const std::function<void()>& work) = 0;
};

// Runs `work` on a separate thread. Meanwhile the calling thread releases the GIL, checks for
// Ctrl-C fifty times a second and passes messages to Python's `logging`. Throws what `work`, a
// signal handler or run_in_python() throws.
void run_call(const std::function<void(Call&)>& work);

template <typename Work>
auto run_call_for_result(const Work& work) {
  std::optional<decltype(work(std::declval<Call&>()))> result;
  run_call([&](Call& call) { result = work(call); });
  return std::move(*result);
}

// Whether this process was forked from one that had already used the library. The library's threads
// do not exist in such a process.
bool is_forked();

// Call once, when the module is imported.
void init_calls();

// Decodes bytes as UTF-8. Invalid bytes become backslash escapes.
py::str text(std::string_view bytes);

}  // namespace emberline::python
