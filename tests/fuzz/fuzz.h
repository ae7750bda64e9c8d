// What the fuzz targets share. Each is a function LLVMFuzzerTestOneInput that hands its bytes to
// one reader; whatever the bytes are, the reader either returns what its header promises or throws
// one of our errors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "renderer/core/load_progress.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace emberline::fuzz {

// Ends the process, as a finding, if the result of a reader has a flaw.
void require_none(const std::string& flaw);

// Calls `read`, which may throw an EmberlineError of some hundred characters and nothing else.
void allow_errors(const std::function<void()>& read);

// What a load may take: less than libFuzzer allows the process (ci/fuzz.sh).
LoadLimits small_limits(const std::string& path);

// Writes the input to a file of this process and returns its path: the same at each call for the
// same `name`. The folder holds nothing else; ci/fuzz.sh has it in memory ($TMPDIR).
std::string write_input(const uint8_t* data, size_t size, const char* name);

}  // namespace emberline::fuzz
