#include "renderer/api/python/calls.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "renderer/api/emberline.h"

namespace emberline::python {
namespace {

// This interval is so short that Ctrl-C seems to take effect at once.
constexpr auto kPollInterval = std::chrono::milliseconds(20);

// Any thread may log a message while the library holds a lock. If it then acquired the GIL, it
// could deadlock with another thread that holds the GIL and logs. So messages are queued.
struct Messages {
  std::mutex mutex;
  std::vector<std::pair<api::Message, std::string>> queued;
};
// The queue is never destroyed, since a thread may log while the process ends.
Messages& messages() {
  static auto* const all = new Messages;
  return *all;
}

void log_messages() {
  std::vector<std::pair<api::Message, std::string>> now;
  {
    const std::lock_guard lock(messages().mutex);
    now.swap(messages().queued);
  }
  if (now.empty()) return;
  const py::object logger = py::module_::import("logging").attr("getLogger")("emberline");
  for (const auto& [kind, message] : now) {
    const char* const level = kind == api::Message::kError     ? "error"
                              : kind == api::Message::kWarning ? "warning"
                                                               : "info";
    logger.attr(level)("%s", text(message));
  }
}

std::atomic<bool> g_is_finalizing{false};
std::atomic<int> g_calls{0};

constexpr const char* kForked =
    "this process was forked from one that has used emberline; call "
    "multiprocessing.set_start_method(\"spawn\") first";

// The id of the process that made the first call; 0 before the first call.
std::atomic<pid_t> g_process{0};

// Throws in a process that was forked after the library had started threads. These threads do not
// exist in the forked process, so waiting for them would never end.
void check_process() {
  pid_t none = 0;
  g_process.compare_exchange_strong(none, ::getpid());
  if (is_forked()) throw api::RenderError(kForked);
}

class WaitingCall final : public Call {
 public:
  std::stop_token cancellation() const override { return cancel_.get_token(); }

  void run_in_python(const std::function<void()>& work) override {
    std::unique_lock lock(mutex_);
    python_work_ = &work;
    changed_.notify_all();
    changed_.wait(lock, [this] { return !python_work_; });
  }

  // Called on the thread that called from Python, without the GIL.
  void wait_for(const std::function<void(Call&)>& work) {
    std::jthread worker([&] {
      std::exception_ptr error;
      try {
        work(*this);
      } catch (...) {
        error = std::current_exception();
      }
      const std::lock_guard lock(mutex_);
      error_ = error;
      done_ = true;
      changed_.notify_all();
    });
    std::unique_lock lock(mutex_);
    while (!done_) {
      changed_.wait_for(lock, kPollInterval, [this] { return done_ || python_work_; });
      if (done_) break;
      const std::function<void()>* const python_work = python_work_;
      lock.unlock();
      attend_to_python(python_work);
      if (is_forked()) {  // a callback forked; the worker is in the parent process
        worker.detach();
        error_ = std::make_exception_ptr(api::RenderError(kForked));
        return;
      }
      lock.lock();
      if (python_work) {
        python_work_ = nullptr;
        changed_.notify_all();
      }
    }
  }

  // Called after wait_for(), with the GIL.
  void rethrow() {
    if (error_in_python_) std::rethrow_exception(std::exchange(error_in_python_, nullptr));
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  }

 private:
  void attend_to_python(const std::function<void()>* python_work) {
    const py::gil_scoped_acquire gil;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (g_is_finalizing) throw api::RenderError("the interpreter is shutting down");
      if (python_work && !error_in_python_) (*python_work)();
      log_messages();
    } catch (...) {
      error_in_python_ = std::current_exception();
      cancel_.request_stop();
    }
  }

  std::stop_source cancel_;
  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void()>* python_work_ = nullptr;
  bool done_ = false;
  std::exception_ptr error_, error_in_python_;
};

// Waits for all calls before the interpreter exits. On exit, the interpreter would terminate all
// threads that are waiting for the GIL, and the C++ functions on their stacks cannot handle that.
// (Python's non-daemon threads have already ended.) A forked process does not wait: it has
// inherited the count of calls, but not their threads.
void wait_for_calls() {
  if (is_forked()) return;
  g_is_finalizing = true;
  const py::gil_scoped_release no_gil;
  while (g_calls > 0) std::this_thread::sleep_for(kPollInterval / 4);
}

}  // namespace

bool is_forked() {
  const pid_t first = g_process;
  return first != 0 && first != ::getpid();
}

void run_call(const std::function<void(Call&)>& work) {
  check_process();
  auto call = std::make_unique<WaitingCall>();
  ++g_calls;
  {
    const py::gil_scoped_release no_gil;
    call->wait_for(work);
  }
  --g_calls;
  // If a callback has forked this process, the call is leaked, since its destructor would wait
  // forever for a worker that exists only in the parent process.
  if (is_forked()) call.release()->rethrow();
  call->rethrow();
  log_messages();
}

py::str text(std::string_view bytes) {
  PyObject* const text =
      PyUnicode_DecodeUTF8(bytes.data(), Py_ssize_t(bytes.size()), "backslashreplace");
  if (!text) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(text);
}

void init_calls() {
  // The module `logging` registers functions that run before and after a fork. If a call imported
  // it while another thread forks, only the functions for after the fork would run.
  py::module_::import("logging");
  api::set_log([](api::Message kind, std::string_view message) {
    const std::lock_guard lock(messages().mutex);
    messages().queued.emplace_back(kind, message);
  });
  py::module_::import("atexit").attr("register")(py::cpp_function(&wait_for_calls));
}

}  // namespace emberline::python
