// Reads untrusted JSON: scenes, edits, cached study results.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "renderer/core/load_progress.h"

namespace emberline {

// What to do about a duplicate member. (nlohmann alone would silently keep the last.)
enum class DuplicateMembers : uint8_t {
  kReject,
  kWarn,  // warn and keep the last, as other glTF readers do: such files exist
};

// Parses all of `text` as one document (RFC 8259). Throws InputError, with the JSON pointer after
// `file`, for invalid JSON or UTF-8, trailing text, nesting deeper than 256 levels (readers
// recurse), numbers that overflow, and a document that exceeds the memory budget of `progress`.
// Throws Cancelled. `*memory` receives the reservation for the document, up to fifty times its
// text.
nlohmann::json parse_json(std::string_view text, const std::string& file,
                          DuplicateMembers duplicates = DuplicateMembers::kReject,
                          const LoadProgress& progress = LoadProgress::none(),
                          MemoryReservation* memory = nullptr);

// Reads a small file that people or this program write beside a scene: at most 16 MiB, within the
// memory budget. Throws InputError.
nlohmann::json read_json(const std::string& path,
                         const LoadProgress& progress = LoadProgress::none());

}  // namespace emberline
