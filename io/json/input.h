// Reads untrusted JSON: scenes, edits, cached study results.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "renderer/core/load_progress.h"

namespace emberline {

// How to handle a duplicate member. (On its own, nlohmann silently keeps the last one.)
enum class DuplicateMembers : uint8_t {
  kReject,
  kWarn,  // warn and keep the last, as other glTF readers do; some files have duplicates
};

// Parses all of `text` as one document (RFC 8259). Throws InputError, with `file` and the JSON
// pointer, for invalid JSON or UTF-8, trailing text, nesting deeper than 256 levels (because the
// code that reads the document recurses), numbers that overflow, and a document that exceeds the
// memory budget of `progress`. Throws Cancelled. `*memory` receives the reservation for the
// document, which can need fifty times as much memory as its text.
nlohmann::json parse_json(std::string_view text, const std::string& file,
                          DuplicateMembers duplicates = DuplicateMembers::kReject,
                          const LoadProgress& progress = LoadProgress::none(),
                          MemoryReservation* memory = nullptr);

// Reads a small JSON file that a user or this program has written beside a scene. Throws
// InputError, also if the file is larger than 16 MiB or exceeds the memory budget.
nlohmann::json read_json(const std::string& path,
                         const LoadProgress& progress = LoadProgress::none());

}  // namespace emberline
