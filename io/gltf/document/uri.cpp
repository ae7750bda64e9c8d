#include "io/gltf/document/uri.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <optional>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

constexpr std::array<int8_t, 256> make_base64_table() {
  std::array<int8_t, 256> table{};
  for (int8_t& entry : table) entry = -1;
  constexpr std::string_view alphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < alphabet.size(); ++i) table[uint8_t(alphabet[i])] = int8_t(i);
  return table;
}
constexpr std::array<int8_t, 256> kBase64 = make_base64_table();

// Follows RFC 4648 section 4. Some exporters omit the padding, so it may be missing, but it must
// not be wrong.
std::vector<uint8_t> decode_base64(std::string_view text, const std::string& place) {
  size_t padding = 0;
  while (!text.empty() && text.back() == '=' && padding < 2) {
    text.remove_suffix(1);
    ++padding;
  }
  if (text.size() % 4 == 1) throw InputError(place, "the base64 data has an invalid length");
  if (padding > 0 && (text.size() + padding) % 4 != 0) {
    throw InputError(place, "the base64 data has invalid padding");
  }
  std::vector<uint8_t> bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  uint32_t bits = 0;
  int bit_count = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    const int8_t value = kBase64[uint8_t(text[i])];
    if (value < 0) {
      throw InputError(place, "the base64 data has an invalid character at position {}", i);
    }
    bits = (bits << 6) | uint32_t(value);
    bit_count += 6;
    if (bit_count >= 8) {
      bit_count -= 8;
      bytes.push_back(uint8_t(bits >> bit_count));
    }
  }
  return bytes;
}

// Returns the byte that the escape at text[i] ('%') encodes, or -1 if the escape is malformed.
int escaped_byte(std::string_view text, size_t i) {
  const std::string_view digits = text.substr(i + 1, 2);
  unsigned byte = 0;
  const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), byte, 16).ptr;
  return digits.size() == 2 && end == digits.data() + 2 ? int(byte) : -1;
}

struct Unescaped {
  std::string text;
  bool is_valid = true;  // whether every % begins an escape that was decoded
};

// Decodes the percent escapes of bytes >= `min_byte`. Keeps all other text as it is.
Unescaped unescape(std::string_view text, int min_byte) {
  Unescaped result;
  result.text.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    const int byte = text[i] == '%' ? escaped_byte(text, i) : -1;
    result.is_valid = result.is_valid && (text[i] != '%' || byte >= min_byte);
    result.text += byte >= min_byte ? char(byte) : text[i];
    if (byte >= min_byte) i += 2;
  }
  return result;
}

InputError malformed_escape(std::string_view uri, const std::string& place) {
  return InputError(place, "malformed % escape in the URI " + shortened(uri));
}

// Follows RFC 3986 section 3.1: a scheme is a letter, then letters, digits, "+", "-" or ".", then
// ":".
bool has_scheme(std::string_view uri) {
  const size_t colon = uri.find(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return is_letter(uri[0]) && std::ranges::all_of(uri.substr(0, colon), [&](char c) {
           return is_letter(c) || (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
         });
}

std::filesystem::path file_in_root(const std::filesystem::path& relative, std::string_view uri,
                                   const ResourceFolder& folder, const std::string& place) {
  if (relative.is_absolute()) {
    throw InputError(
        place,
        "the URI {} is an absolute path; copy the file next to the scene and use a relative URI",
        shortened(uri));
  }
  std::error_code error, root_error;
  const std::filesystem::path file =
      std::filesystem::weakly_canonical(folder.directory / relative, error);
  const std::filesystem::path root = std::filesystem::weakly_canonical(folder.root, root_error);
  if (!error) error = root_error;
  if (error) {
    throw InputError(place, "cannot access the file {}: {}", shortened(uri), error.message());
  }
  const auto [in_root, in_file] = std::mismatch(root.begin(), root.end(), file.begin(), file.end());
  const bool ends_in_slash = in_root != root.end() && in_root->empty();
  if (in_root != root.end() && !ends_in_slash) {
    throw InputError(
        place, "the URI " + shortened(uri) + " points outside the scene's folder, to " +
                   shortened(file.string()) + "; use `resource-root` DIR to allow files in DIR");
  }
  return file;
}

// Returns the file names that a URI may mean. The likeliest name comes first. A query and a
// fragment count as parts of the name.
std::vector<std::string> candidate_names(std::string_view uri) {
  const std::string decoded = unescape(uri, 1).text;
  std::vector<std::string> names = {decoded};
  if (decoded != uri) names.emplace_back(uri);
  for (size_t i = 0, count = names.size(); i < count; ++i) {
    if (names[i].find('\\') == std::string::npos) continue;
    names.push_back(names[i]);
    std::ranges::replace(names.back(), '\\', '/');
  }
  return names;
}

bool is_mime_token(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return c > ' ' && c <= '~' && !std::strchr("()<>@,;:\\\"/[]?=", c);
  });
}

}  // namespace

bool is_data_uri(std::string_view uri) { return uri.substr(0, 5) == "data:"; }

std::vector<uint8_t> decode_data_uri(std::string_view uri, const std::string& place) {
  const size_t comma = uri.find(',');
  if (!is_data_uri(uri) || comma == std::string_view::npos) {
    throw InputError(place, "data URI without a comma before its data: " + shortened(uri));
  }
  std::string_view head = uri.substr(5, comma - 5);
  const std::string_view payload = uri.substr(comma + 1);

  // A media type comes first, then parameters. Only the last of them may be the bare word "base64"
  // (RFC 2397).
  constexpr std::string_view kBase64Mark = ";base64";
  const bool base64 = head.ends_with(kBase64Mark);
  if (base64) head.remove_suffix(kBase64Mark.size());
  size_t end = head.find(';');
  const std::string_view type = head.substr(0, end);
  const size_t slash = type.find('/');
  const bool typed = slash != std::string_view::npos && is_mime_token(type.substr(0, slash)) &&
                     is_mime_token(type.substr(slash + 1));
  if (!type.empty() && !typed) {
    throw InputError(place, "data URI with a malformed media type: " + shortened(uri));
  }
  while (end != std::string_view::npos) {
    head.remove_prefix(end + 1);
    end = head.find(';');
    const std::string_view parameter = head.substr(0, end);
    const size_t equals = parameter.find('=');
    if (equals == std::string_view::npos || !is_mime_token(parameter.substr(0, equals))) {
      throw InputError(place, "data URI with a malformed parameter: " + shortened(uri));
    }
  }

  if (base64) {
    // Some writers percent-encode "+", "/" and "=".
    if (payload.find('%') == std::string_view::npos) return decode_base64(payload, place);
    const Unescaped text = unescape(payload, 1);
    if (!text.is_valid) throw malformed_escape(payload, place);
    return decode_base64(text.text, place);
  }
  const Unescaped bytes = unescape(payload, 0);
  if (!bytes.is_valid) throw InputError(place, "data URI with a malformed % escape");
  return {bytes.text.begin(), bytes.text.end()};
}

ResolvedUri resolve_uri(std::string_view uri, const ResourceFolder& folder,
                        const std::string& place) {
  if (uri.empty()) throw InputError(place, "empty URI");
  if (has_scheme(uri)) {
    throw InputError(
        place, "the URI {} is not relative; copy the file next to the scene and use a relative URI",
        shortened(uri));
  }
  if (uri.find('\0') != std::string_view::npos) {
    throw InputError(place, "the URI contains a NUL character");
  }
  std::optional<InputError> fault;
  std::optional<ResolvedUri> first_missing;
  if (!unescape(uri, 1).is_valid) fault = malformed_escape(uri, place);
  for (const std::string& name : candidate_names(uri)) {
    try {
      ResolvedUri found = {name, file_in_root(name, uri, folder, place)};
      std::error_code ignored;
      if (std::filesystem::exists(found.file, ignored)) return found;
      if (!first_missing) first_missing = std::move(found);
    } catch (const InputError& error) {
      if (!fault) fault = error;
    }
  }
  if (fault) throw InputError(*fault);
  return *first_missing;  // opening this file reports that it is missing
}

}  // namespace emberline
