// JSON from files that nobody vouches for: scenes, edits, what a study has kept.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "renderer/core/load_progress.h"

namespace emberline {

// What becomes of an object that has a member twice, of which the last would win in silence.
enum class DuplicateMembers : uint8_t {
  kRefused,
  kWarnedOf,  // and the last counts, as in every other reader of glTF: such files exist
};

// The whole `text` as one document (RFC 8259). Throws InputError, with the JSON pointer behind
// `file`, for text that is no JSON or no UTF-8 or has something behind its end, for nesting deeper
// than 256 levels (what reads a document recurses), for numbers too large to be finite, and for a
// document that takes more memory than the budget of `progress` has left; and Cancelled. `*memory`
// is what it takes, up to fifty times its text.
nlohmann::json parse_json(std::string_view text, const std::string& file,
                          DuplicateMembers duplicates = DuplicateMembers::kRefused,
                          const LoadProgress& progress = LoadProgress::unwatched(),
                          MemoryReservation* memory = nullptr);

// A file that people or this program write beside a scene: of 16 MiB at most, within the budget.
// Throws InputError.
nlohmann::json read_json(const std::string& path,
                         const LoadProgress& progress = LoadProgress::unwatched());

}  // namespace emberline
