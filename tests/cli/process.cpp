#include "cli/process.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#ifndef AT_EMPTY_PATH
#define AT_EMPTY_PATH 0x1000
#endif

namespace emberline::test {
namespace {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string contents(int descriptor) {
  std::string text;
  char block[4096];
  off_t offset = 0;
  for (ssize_t n; (n = ::pread(descriptor, block, sizeof block, offset)) > 0; offset += n) {
    text.append(block, size_t(n));
  }
  return text;
}

// Restricts this process to its first `count` processors, as taskset does.
void keep_processors(int count) {
  cpu_set_t set;
  if (::sched_getaffinity(0, sizeof set, &set) != 0) ::_exit(126);
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &set) && --count < 0) CPU_CLR(cpu, &set);
  }
  if (::sched_setaffinity(0, sizeof set, &set) != 0) ::_exit(126);
}

}  // namespace

std::vector<std::string> RunResult::error_lines() const {
  std::vector<std::string> lines;
  std::istringstream stream(err);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string RunResult::describe() const {
  std::ostringstream text;
  text << (hung     ? "hung"
           : signal ? "ended by signal " + std::to_string(signal)
                    : "exit code " + std::to_string(exit_code));
  text << " after " << seconds << " s\nstdout: " << out << "\nstderr: " << err;
  return text.str();
}

Process::Process(const std::vector<std::string>& arguments, const RunOptions& options)
    : options_(options), started_(now()) {
  // Open the program before dropping privileges, because other users may not be able to read the
  // build folder.
  const int binary = ::open(EMBERLINE_BINARY, O_RDONLY | O_CLOEXEC);
  out_ = ::memfd_create("stdout", MFD_CLOEXEC);
  int terminal = -1;
  if (options_.terminal_columns > 0) {
    winsize size = {};
    size.ws_row = 25;
    size.ws_col = static_cast<unsigned short>(options_.terminal_columns);
    if (::openpty(&err_, &terminal, nullptr, nullptr, &size) != 0) err_ = -1;
  } else {
    err_ = ::memfd_create("stderr", MFD_CLOEXEC);
  }
  if (binary < 0 || out_ < 0 || err_ < 0) throw std::runtime_error("cannot run " EMBERLINE_BINARY);
  if (!options_.stdout_path.empty()) {
    ::close(out_);
    out_ = ::open(options_.stdout_path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  }
  std::fflush(nullptr);
  pid_ = ::fork();
  if (pid_ == 0) {
    ::dup2(out_, STDOUT_FILENO);
    int broken[2] = {-1, -1};
    if (options_.stderr_reader_gone && ::pipe2(broken, O_CLOEXEC) == 0) ::close(broken[0]);
    ::dup2(broken[1] >= 0 ? broken[1] : terminal >= 0 ? terminal : err_, STDERR_FILENO);
    run_child(arguments, binary);
  }
  ::close(binary);
  if (terminal >= 0) ::close(terminal);
}

// Runs between fork and exec. Applies the options, and then starts the program.
void Process::run_child(const std::vector<std::string>& arguments, int binary) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU, SIGPIPE, SIGXFSZ}) {
    std::signal(signal, SIG_DFL);
  }
  if (options_.ignored_signal) std::signal(options_.ignored_signal, SIG_IGN);
  if (!options_.folder.empty() && ::chdir(options_.folder.c_str()) != 0) ::_exit(126);
  ::unsetenv("OCIO");
  ::setenv("TERM", "xterm", 1);
  for (const auto& [name, value] : options_.environment) ::setenv(name.c_str(), value.c_str(), 1);
  if (options_.file_size_limit > 0) {
    const rlimit limit = {options_.file_size_limit, options_.file_size_limit};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  if (options_.data_limit > 0) {
    const rlimit limit = {options_.data_limit, options_.data_limit};
    ::setrlimit(RLIMIT_DATA, &limit);
  }
  if (options_.processors > 0) keep_processors(options_.processors);
  uid_t user = 65534;
  if (options_.process_limit > 0) {
    const rlimit limit = {options_.process_limit, options_.process_limit};
    ::setrlimit(RLIMIT_NPROC, &limit);
    user = 100000 + uid_t(::getpid());  // a new user, because the limit counts all its processes
  }
  const bool other_user = options_.unprivileged || options_.process_limit > 0;
  if (other_user && ::getuid() == 0 && (::setgid(65534) != 0 || ::setuid(user) != 0)) {
    ::_exit(126);
  }
  std::vector<char*> argv = {const_cast<char*>("emberline")};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  for (const int descriptor : options_.closed) ::close(descriptor);
  ::syscall(SYS_execveat, binary, "", argv.data(), environ, AT_EMPTY_PATH);
  ::_exit(126);
}

Process::~Process() {
  if (!ended_ && pid_ > 0) {
    ::kill(pid_, SIGKILL);
    poll(0);
  }
  if (out_ >= 0) ::close(out_);
  if (err_ >= 0) ::close(err_);
}

void Process::send(int signal) {
  signalled_cpu_s_ = cpu_seconds();
  ::kill(pid_, signal);
}

// Reads fields 14 and 15 of /proc/PID/stat, see proc(5). Skips the name of the process, which may
// contain blanks.
double Process::cpu_seconds() const {
  std::ifstream file("/proc/" + std::to_string(pid_) + "/stat");
  std::string text;
  std::getline(file, text);
  std::istringstream fields(text.substr(std::min(text.size(), text.rfind(')') + 1)));
  std::string skipped;
  for (int i = 3; i < 14; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / double(::sysconf(_SC_CLK_TCK));
}

// Returns whether the process has ended. If `flags` is 0, waits until it has ended.
bool Process::poll(int flags) {
  if (ended_) return true;
  int status = 0;
  rusage usage = {};
  if (::wait4(pid_, &status, flags, &usage) != pid_) return false;
  ended_ = true;
  result_.seconds = now() - started_;
  const auto seconds_of = [](const timeval& t) {
    return double(t.tv_sec) + 1e-6 * double(t.tv_usec);
  };
  result_.stop_cpu_s = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime) - signalled_cpu_s_;
  result_.peak_rss_bytes = uint64_t(usage.ru_maxrss) * 1024;
  if (WIFEXITED(status)) result_.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result_.signal = WTERMSIG(status);
  return true;
}

void Process::read_terminal() {
  char block[4096];
  for (pollfd ready = {err_, POLLIN, 0}; ::poll(&ready, 1, 0) > 0;) {
    const ssize_t n = ::read(err_, block, sizeof block);
    if (n <= 0) return;
    terminal_text_.append(block, size_t(n));
  }
}

std::string Process::error_so_far() {
  if (options_.terminal_columns == 0) return contents(err_);
  read_terminal();
  return terminal_text_;
}

bool Process::wait_for_error(const std::string& text, double seconds) {
  const double end = now() + seconds;
  while (now() < end) {
    if (error_so_far().find(text) != std::string::npos) return true;
    if (poll(WNOHANG)) return false;
    ::usleep(2000);
  }
  return false;
}

bool Process::wait_until_busy(const std::string& text, double cpu_s) {
  if (!wait_for_error(text, options_.timeout_s)) return false;
  for (const double end = cpu_seconds() + cpu_s; cpu_seconds() < end; ::usleep(2000)) {
    if (poll(WNOHANG) || now() - started_ > options_.timeout_s) return false;
  }
  return true;
}

RunResult Process::wait() {
  while (!poll(WNOHANG)) {
    if (now() - started_ > options_.timeout_s) {
      ::kill(pid_, SIGKILL);
      poll(0);
      result_.hung = true;
    }
    if (options_.terminal_columns > 0) read_terminal();
    ::usleep(2000);
  }
  if (options_.stdout_path.empty()) result_.out = contents(out_);
  result_.err = error_so_far();
  return result_;
}

RunResult run(const std::vector<std::string>& arguments, const RunOptions& options) {
  Process process(arguments, options);
  return process.wait();
}

}  // namespace emberline::test
