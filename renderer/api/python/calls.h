// Long calls from Python: without the interpreter's lock (GIL), stopped by Ctrl-C.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <stop_token>
#include <string_view>
#include <utility>

namespace emberline::python {

namespace py = pybind11;

// A long call as the code that carries it out sees it.
class Call {
 public:
  virtual ~Call() = default;
  // Asks for the end once something was thrown in Python: nobody waits for a result any more.
  virtual std::stop_token given_up() const = 0;
  // Runs `work` on the thread that called from Python, with the GIL, and waits for its end; not
  // once the call is given up.
  virtual void in_python(const std::function<void()>& work) = 0;
};

// Runs `work` on a thread of its own. This one gives the GIL away and waits, looks for Ctrl-C fifty
// times a second and hands messages to Python's `logging`. Throws what `work`, a signal handler or
// in_python() has thrown.
void carry_out(const std::function<void(Call&)>& work);

template <typename Work>
auto result_of(const Work& work) {
  std::optional<decltype(work(std::declval<Call&>()))> result;
  carry_out([&](Call& call) { result = work(call); });
  return std::move(*result);
}

// Whether this process was forked from one that had used the library: its threads are not here.
bool is_forked();

// Once, when the module is imported.
void set_up_calls();

// Text of whatever bytes.
py::str text(std::string_view bytes);

}  // namespace emberline::python
