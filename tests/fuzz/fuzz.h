// Shared by the fuzz targets. Each target is a function LLVMFuzzerTestOneInput that passes its
// bytes to one reader. For any bytes, the reader must return what its header promises or throw an
// EmberlineError.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "renderer/core/load_progress.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace emberline::fuzz {

// Aborts, which libFuzzer reports as a finding, if a reader's result has a flaw.
void require_none(const std::string& violation);

// Calls `read`, which may only throw an EmberlineError with a message of at most a few hundred
// characters.
void allow_errors(const std::function<void()>& read);

// Limits for a load, below libFuzzer's limits for the process (ci/fuzz.sh).
LoadLimits small_limits(const std::string& path);

// Writes the input to a file of this process and returns its path, which depends only on `name`.
// The folder contains nothing else; ci/fuzz.sh puts it in memory ($TMPDIR).
std::string write_input(const uint8_t* data, size_t size, const char* name);

}  // namespace emberline::fuzz
