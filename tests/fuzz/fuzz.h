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

// Aborts if `violation` names a flaw in a reader's result. libFuzzer reports the abort as a
// finding.
void require_none(const std::string& violation);

// Calls `read`, which may only throw an EmberlineError with a message of at most 2000 characters.
void allow_errors(const std::function<void()>& read);

// Returns limits for a load, which are below libFuzzer's limits for the process (ci/fuzz.sh).
LoadLimits small_limits(const std::string& path);

// Writes the input to a file of this process and returns the file's path, which depends only on
// `name`. The file's folder contains nothing else. ci/fuzz.sh puts the folder in memory ($TMPDIR).
std::string write_input(const uint8_t* data, size_t size, const char* name);

}  // namespace emberline::fuzz
