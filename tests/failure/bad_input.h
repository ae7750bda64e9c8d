// Expectations for unusable files.
#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>

#include "io/gltf/gltf_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "support/gltf_builder.h"

namespace emberline::test {

// Limits the address space during its lifetime, so that an allocation whose size is an unchecked
// count fails.
class MemoryLimit {
 public:
  explicit MemoryLimit(uint64_t bytes) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    getrlimit(RLIMIT_AS, &before_);
    rlimit limited = before_;
    limited.rlim_cur = std::min<rlim_t>(bytes, before_.rlim_max);
    setrlimit(RLIMIT_AS, &limited);
    active_ = true;
#else
    (void)bytes;  // sanitizers reserve terabytes of addresses
#endif
  }
  ~MemoryLimit() {
    if (active_) setrlimit(RLIMIT_AS, &before_);
  }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit before_{};
  bool active_ = false;
};

// Expects that loading throws InputError. The message must be one line that begins with the file's
// name and contains each of `parts`.
inline void expect_input_error(const std::string& path, const std::vector<std::string>& parts,
                               const GltfOptions& options = {}) {
  try {
    load_gltf(path, options);
    ADD_FAILURE() << path << " was accepted";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.exit_code(), kExitInput);
    EXPECT_EQ(message.rfind(path, 0), 0u) << "does not begin with the file: " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 1000u) << message;
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << "lacks \"" << part << "\": " << message;
    }
  }
}

inline void expect_input_error(const GltfBuilder& gltf, const std::vector<std::string>& parts,
                               const GltfOptions& options = {}) {
  const TempFolder folder;
  expect_input_error(gltf.write_glb(folder / "a.glb"), parts, options);
}

// Expects that loading returns the scene, with exactly one warning that is one line, begins with
// the file's name, and contains each of `parts`.
inline SceneDescription expect_warning(const std::string& path,
                                       const std::vector<std::string>& parts,
                                       const GltfOptions& options = {}) {
  std::vector<std::string> warnings;
  set_log_sink([&](LogKind, std::string_view message) { warnings.emplace_back(message); });
  SceneDescription scene;
  try {
    scene = load_gltf(path, options);
  } catch (const InputError& error) {
    ADD_FAILURE() << "refused: " << error.what();
  }
  set_log_sink(nullptr);
  const auto fits = [&](const std::string& message) {
    return message.rfind(path, 0) == 0 && message.find('\n') == std::string::npos &&
           std::ranges::all_of(parts, [&](const std::string& part) {
             return message.find(part) != std::string::npos;
           });
  };
  EXPECT_EQ(std::ranges::count_if(warnings, fits), 1)
      << "no single warning with " << parts.front() << " among " << warnings.size() << ": "
      << (warnings.empty() ? "" : warnings.back());
  return scene;
}

inline SceneDescription expect_warning(const GltfBuilder& gltf,
                                       const std::vector<std::string>& parts,
                                       const GltfOptions& options = {}) {
  const TempFolder folder;
  return expect_warning(gltf.write_glb(folder / "a.glb"), parts, options);
}

// Returns the error of loading with a memory budget, or "no error" if there is none.
inline std::string rejection_message(const GltfBuilder& gltf, uint64_t budget) {
  const TempFolder folder;
  const std::string path = gltf.write_glb(folder / "a.glb");
  LoadProgress progress({}, {}, {std::make_shared<MemoryBudget>(budget), std::nullopt, path});
  try {
    load_gltf(path, {}, progress);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace emberline::test
