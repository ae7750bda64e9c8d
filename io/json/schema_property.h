// Types and helpers for the schema tables of glTF objects (gltf/document/schema.cpp).
#pragma once

#include <cfloat>
#include <cstddef>
#include <cstdint>
#include <span>

namespace emberline::schema {

enum class Kind : uint8_t {
  kInteger,  // minimum..maximum
  kIndex,    // index into the array `target`
  kNumber,   // minimum..maximum
  kNumbers,  // `count` numbers; any number of them if `count` is 0
  kBoolean,
  kString,
  kStrings,
  kIndices,    // array of indices into `target`
  kIndexMap,   // object: name -> index into `target` (any index if `target` is null)
  kIndexMaps,  // array of index maps
  kObject,     // object with the members of `schema`
  kObjects,    // array of objects with the members of `schema`
};

struct Property;
using Schema = std::span<const Property>;

// The effect of a fault in a member. In every case, a faulty optional member is removed if it is
// null or inside an optional extension.
enum class OnFault : uint8_t {
  kInvalidatesParent,  // the object that has the member is unusable
  kDefaulted,          // the member is removed, or set to 1 if it is required
  kPerElement,         // arrays and maps: only the faulty element is broken and becomes null
};

struct Property {
  const char* name;
  Kind kind;
  bool required = false;
  double minimum = -FLT_MAX;
  double maximum = FLT_MAX;
  size_t count = 0;
  const char* target = nullptr;
  Schema schema;
  OnFault on_fault = OnFault::kInvalidatesParent;
  bool propagates_fault = false;  // for an index: if its target is broken, so is this object
  // For an extension: its faults are errors even if the file does not require the extension. For
  // kPerElement: a member that is not an array is an error; without this flag, the member counts as
  // an empty array.
  bool essential = false;
};

constexpr double kLargestInteger = 0x1p53;  // larger JSON integers may be inexact

constexpr Property integer(const char* name, double minimum = 0, double maximum = kLargestInteger) {
  return {name, Kind::kInteger, false, minimum, maximum, 0, nullptr, {}};
}
constexpr Property number(const char* name, double minimum = -FLT_MAX, double maximum = FLT_MAX) {
  return {name, Kind::kNumber, false, minimum, maximum, 0, nullptr, {}};
}
constexpr Property positive(const char* name) { return number(name, FLT_TRUE_MIN); }
// Any number; the code that reads it checks the range and may be lenient.
constexpr Property any_number(const char* name) {
  return {name, Kind::kNumber, false, -DBL_MAX, DBL_MAX, 0, nullptr, {}};
}
constexpr Property numbers(const char* name, size_t count) {
  return {name, Kind::kNumbers, false, -FLT_MAX, FLT_MAX, count, nullptr, {}};
}
constexpr Property plain(const char* name, Kind kind) {
  return {name, kind, false, 0, 0, 0, nullptr, {}};
}
constexpr Property boolean(const char* name) { return plain(name, Kind::kBoolean); }
constexpr Property string(const char* name) { return plain(name, Kind::kString); }
constexpr Property reference(const char* name, Kind kind, const char* target) {
  return {name, kind, false, 0, 0, 0, target, {}};
}
constexpr Property index(const char* name, const char* target) {
  return reference(name, Kind::kIndex, target);
}
constexpr Property object(const char* name, Schema schema) {
  return {name, Kind::kObject, false, 0, 0, 0, nullptr, schema};
}
constexpr Property objects(const char* name, Schema schema) {
  return {name, Kind::kObjects, false, 0, 0, 0, nullptr, schema};
}
constexpr Property required(Property property) {
  property.required = true;
  return property;
}
constexpr Property defaultable(Property property) {
  property.on_fault = OnFault::kDefaulted;
  return property;
}
constexpr Property per_element(Property property) {
  property.on_fault = OnFault::kPerElement;
  return property;
}
constexpr Property propagating(Property property) {
  property.propagates_fault = true;
  return property;
}
constexpr Property essential(Property property) {
  property.essential = true;
  return property;
}
constexpr Property name() { return defaultable(string("name")); }

}  // namespace emberline::schema
