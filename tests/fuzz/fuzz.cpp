#include "fuzz/fuzz.h"

#include <OpenImageIO/imageio.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"

// One thread makes an input's path through the code reproducible.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  static const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  OIIO::attribute("threads", 1);
  emberline::set_log_level(emberline::LogLevel::kQuiet);
  return 0;
}

namespace emberline::fuzz {

void require_none(const std::string& violation) {
  if (violation.empty()) return;
  std::fprintf(stderr, "fuzz: broken promise: %s\n", violation.c_str());
  std::abort();
}

void allow_errors(const std::function<void()>& read) try {
  read();
} catch (const EmberlineError& error) {
  if (std::string_view(error.what()).size() > 2000) require_none("an error of one line");
}

LoadLimits small_limits(const std::string& path) {
  return {std::make_shared<MemoryBudget>(uint64_t(1) << 27), std::nullopt, path};
}

std::string write_input(const uint8_t* data, size_t size, const char* name) {
  static const std::filesystem::path folder = [] {
    const auto path = std::filesystem::temp_directory_path() / ("fuzz-" + std::to_string(getpid()));
    std::filesystem::create_directories(path);
    return path;
  }();
  const std::string path = (folder / name).string();
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), std::streamsize(size));
  return path;
}

}  // namespace emberline::fuzz
