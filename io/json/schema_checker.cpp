#include "io/json/schema_checker.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "renderer/core/shortened.h"

namespace emberline::schema {
namespace {

using nlohmann::json;

// Whether the extension counts as absent, because it or one of its required members is null.
bool is_null_extension(const json& extension, Schema schema) {
  return extension.is_null() || std::ranges::any_of(schema, [&](const Property& property) {
           if (!property.required || !extension.is_object()) return false;
           const auto member = extension.find(property.name);
           return member != extension.end() && member->is_null();
         });
}

class SchemaChecker {
 public:
  SchemaChecker(json& root, const std::string& file, GltfFaults& faults)
      : root_(root), file_(file), faults_(faults) {
    if (!root.is_object() || !root.contains("extensionsRequired")) return;
    const json& names = root.at("extensionsRequired");
    if (!names.is_array()) return;
    for (const json& name : names) {
      if (name.is_string()) required_.insert(name.get<std::string>());
    }
  }

  void check(Schema schema) {
    // Members that should be arrays are checked first. If one is not an array, the message for an
    // index into it can then name this cause, instead of an index that is out of range.
    for (const Property& property : schema) {
      if (property.on_fault != OnFault::kPerElement || property.essential || !root_.is_object())
        continue;
      const auto member = root_.find(property.name);
      if (member == root_.end() || member->is_array()) continue;
      const PointerScope step(pointer_, property.name);
      try {
        fail_type("an array", *member);
      } catch (const InputError& error) {
        faults_.note_broken(pointer_.to_string(), error);
        *member = json::array();
      }
    }
    check_object(root_, schema);
    list_extensions();
  }

 private:
  // Appends a name to the JSON pointer for the lifetime of this object.
  class PointerScope {
   public:
    PointerScope(json::json_pointer& pointer, std::string name) : pointer_(pointer) {
      pointer_.push_back(std::move(name));
    }
    ~PointerScope() { pointer_.pop_back(); }
    PointerScope(const PointerScope&) = delete;
    PointerScope& operator=(const PointerScope&) = delete;

   private:
    json::json_pointer& pointer_;
  };

  // Adds the extensions found to extensionsUsed, since some writers forget to list them.
  void list_extensions() {
    if (found_.empty()) return;
    json& used = root_["extensionsUsed"];
    for (const json& name : used) found_.erase(name.get_ref<const std::string&>());
    for (const std::string& name : found_) used.push_back(name);
  }

  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(file_ + (pointer_.empty() ? "" : "#" + shortened(pointer_.to_string())),
                     message);
  }

  [[noreturn]] void fail_type(const std::string& expected, const json& found) const {
    const bool is_scalar = found.is_number() || found.is_string() || found.is_boolean();
    fail("expected " + expected + ", found " +
         (is_scalar ? shortened(found.dump(-1, ' ', true)) : std::string(found.type_name())));
  }

  // The recursion is only as deep as the tables are nested.
  void check_object(json& value, Schema schema) {
    if (!value.is_object()) fail_type("an object", value);
    for (const Property& property : schema) {
      const auto member = value.find(property.name);
      if (member == value.end()) {
        if (property.required) handle_missing_member(value, property);
        continue;
      }
      const PointerScope step(pointer_, property.name);
      check_member(value, member, property);
    }
  }

  void handle_missing_member(json& object, const Property& property) {
    const auto fail_missing = [&] {
      fail(std::string("the required member \"") + property.name + "\" is missing");
    };
    if (property.on_fault != OnFault::kDefaulted) fail_missing();
    try {
      fail_missing();
    } catch (const InputError& error) {
      const PointerScope step(pointer_, property.name);
      faults_.note_defaulted(pointer_.to_string(), error);
      object[property.name] = 1;
    }
  }

  void check_member(json& object, json::iterator member, const Property& property) {
    const bool is_absent = member->is_null() && !pointer_.parent_pointer().empty();
    const bool is_defaultable = property.on_fault == OnFault::kDefaulted ||
                                (!property.required && (optional_ || is_absent));
    if (!is_defaultable) return check_property(*member, property);
    try {
      check_property(*member, property);
    } catch (const InputError& error) {
      faults_.note_defaulted(pointer_.to_string(), error);
      if (property.required) {
        *member = 1;
      } else {
        object.erase(member);
      }
    }
  }

  void check_extensions(json& value, Schema schema) {
    if (!value.is_object()) {
      // Some exporters write an empty object as an empty array.
      if (value.is_array() && value.empty() && required_.empty()) return;
      fail_type("an object", value);
    }
    constexpr size_t kMaxFound = 100;
    for (const auto& [name, ignored] : value.items()) {
      if (found_.size() < kMaxFound) found_.insert(name);
    }
    for (const Property& property : schema) {
      const auto member = value.find(property.name);
      if (member == value.end()) continue;
      const PointerScope step(pointer_, property.name);
      check_extension(value, member, property);
    }
  }

  void check_extension(json& extensions, json::iterator member, const Property& property) {
    const bool optional = !required_.contains(property.name) &&
                          (!property.essential || is_null_extension(*member, property.schema));
    const bool was_optional = std::exchange(optional_, optional);
    try {
      check_property(*member, property);
      optional_ = was_optional;
    } catch (const InputError& error) {
      optional_ = was_optional;
      if (!optional) throw;
      faults_.note_defaulted(pointer_.to_string(), error);
      extensions.erase(member);
    }
  }

  template <class CheckElement>
  void check_array(json& value, const CheckElement& check_element) {
    if (!value.is_array()) fail_type("an array", value);
    size_t i = 0;
    for (json& element : value) {
      const PointerScope step(pointer_, std::to_string(i++));
      check_element(element);
    }
  }

  // Checks one element. With OnFault::kPerElement, a broken element is noted and becomes null.
  template <class Check>
  void check_element(json& element, const Property& property, const Check& check) {
    if (property.on_fault != OnFault::kPerElement) return check();
    try {
      check();
    } catch (const InputError& error) {
      faults_.note_broken(pointer_.to_string(), error);
      element = nullptr;
    }
  }

  void check_integer(json& value, double minimum, double maximum) {
    const double number = value.is_number() ? value.get<double>() : -1.0;
    if (!value.is_number() || number != std::floor(number) || std::abs(number) > kLargestInteger) {
      fail_type("a whole number", value);
    }
    if (number < minimum || number > maximum) {
      fail("expected a whole number from " + std::to_string(int64_t(minimum)) + " to " +
           std::to_string(int64_t(maximum)) + ", found " + value.dump());
    }
    if (value.is_number_float()) value = int64_t(number);
  }

  void check_index(json& value, const Property& property) {
    if (!property.target) return check_integer(value, 0, kLargestInteger);
    const json::json_pointer pointer(property.target);
    size_t count = 0;
    if (root_.contains(pointer) && root_.at(pointer).is_array()) count = root_.at(pointer).size();
    const double number = value.is_number() ? value.get<double>() : -1.0;
    if (!value.is_number() || number != std::floor(number) || number < 0) {
      fail_type("an index (a whole number from 0)", value);
    }
    if (!(number < double(count))) {
      faults_.require(property.target);
      fail("index " + value.dump() + " is out of range: the file has " + std::to_string(count) +
           " " + pointer.back());
    }
    if (value.is_number_float()) value = int64_t(number);
    if (property.propagates_fault) {
      faults_.require(property.target + ("/" + std::to_string(value.get<int64_t>())));
    }
  }

  void check_number(const json& value, double minimum, double maximum) {
    if (!value.is_number()) fail_type("a number", value);
    const double number = value.get<double>();
    if (!std::isfinite(number) || number < minimum || number > maximum) {
      fail("the number " + value.dump() + " is out of range");
    }
  }

  void check_index_map(json& value, const Property& property) {
    if (!value.is_object()) fail_type("an object", value);
    for (auto& [name, element] : value.items()) {
      const PointerScope step(pointer_, name);
      check_element(element, property, [&, &e = element] { check_index(e, property); });
    }
  }

  void check_property(json& value, const Property& p) {
    switch (p.kind) {
      case Kind::kInteger:
        return check_integer(value, p.minimum, p.maximum);
      case Kind::kIndex:
        return check_index(value, p);
      case Kind::kNumber:
        return check_number(value, p.minimum, p.maximum);
      case Kind::kNumbers:
        check_array(value, [&](json& e) { check_number(e, p.minimum, p.maximum); });
        if (p.count > 0 && value.size() != p.count) {
          fail("expected " + std::to_string(p.count) + " numbers, found " +
               std::to_string(value.size()));
        }
        return;
      case Kind::kBoolean:
        if (!value.is_boolean()) fail_type("true or false", value);
        return;
      case Kind::kString:
        if (!value.is_string()) fail_type("a string", value);
        return;
      case Kind::kStrings:
        return check_array(value, [&](json& e) {
          if (!e.is_string()) fail_type("a string", e);
        });
      case Kind::kIndices:
        return check_array(value, [&](json& e) { check_index(e, p); });
      case Kind::kIndexMap:
        return check_index_map(value, p);
      case Kind::kIndexMaps:
        return check_array(value, [&](json& e) { check_index_map(e, p); });
      case Kind::kObject:
        return std::string_view(p.name) == "extensions" ? check_extensions(value, p.schema)
                                                        : check_object(value, p.schema);
      case Kind::kObjects:
        return check_array(
            value, [&](json& e) { check_element(e, p, [&] { check_object(e, p.schema); }); });
    }
  }

  json& root_;
  const std::string& file_;
  GltfFaults& faults_;
  std::set<std::string> required_;  // extensions that the file requires
  std::set<std::string> found_;  // extensions found on objects, at most as many as a report shows
  json::json_pointer pointer_;
  bool optional_ = false;  // whether we are inside an extension that the file does not require
};

}  // namespace

void check_document(json& root, const std::string& file, GltfFaults& faults, Schema schema) {
  SchemaChecker(root, file, faults).check(schema);
}

}  // namespace emberline::schema
