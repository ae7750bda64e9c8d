// Reads a JSON document with known members, and validates each value on access.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/shortened.h"
#include "renderer/core/vector.h"

namespace emberline {

// A value in a document, with its JSON pointer. All functions except place(), has() and is_null()
// throw InputError with the file, the JSON pointer and what was expected.
class JsonReader {
 public:
  // `document` and `file` must outlive this reader and all readers made from it.
  JsonReader(const nlohmann::json& document, const std::string& file)
      : JsonReader(document, file, "") {}

  std::string place() const { return pointer_.empty() ? file_ : file_ + "#" + shortened(pointer_); }

  // Requires an object that has only these members.
  const JsonReader& object(std::span<const std::string_view> members) const;
  const JsonReader& object(std::initializer_list<std::string_view> members) const {
    return object(std::span(members.begin(), members.size()));
  }
  bool has(const char* member) const;  // false if this value is not an object
  JsonReader operator[](const std::string& member) const;
  std::vector<std::string> members() const;  // names of an object's members
  size_t size() const;                       // length of an array
  JsonReader operator[](size_t element) const;

  bool is_null() const;
  double number(double minimum, double maximum) const;
  uint64_t whole_number(uint64_t minimum, uint64_t maximum) const;
  bool boolean() const;
  std::string text() const;
  Vec3d vector(double minimum, double maximum) const;

  [[noreturn]] void throw_expected(const std::string& what) const;

 private:
  JsonReader(const nlohmann::json& value, const std::string& file, std::string pointer)
      : json_(value), file_(file), pointer_(std::move(pointer)) {}
  JsonReader member(const std::string& name, const nlohmann::json& value) const;

  const nlohmann::json& json_;
  const std::string& file_;
  std::string pointer_;
};

}  // namespace emberline
