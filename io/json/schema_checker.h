// A JSON document against the tables of gltf/document/schema.cpp.
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "io/gltf/document/faults.h"
#include "io/json/schema_property.h"

namespace emberline::schema {

class SchemaChecker {
 public:
  SchemaChecker(nlohmann::json& root, const std::string& file, GltfFaults& faults);

  // The whole document, as check_schema (gltf/document/schema.h) says.
  void check(Schema schema);

 private:
  using json = nlohmann::json;
  class Step;

  [[noreturn]] void fail(const std::string& message) const;
  [[noreturn]] void fail_type(const std::string& expected, const json& found) const;
  template <class CheckElement>
  void check_array(json& value, const CheckElement& check_element);
  template <class Check>
  void check_element(json& element, const Property& property, const Check& check);
  void check_object(json& value, Schema schema);
  void miss_member(json& object, const Property& property);
  void check_member(json& object, json::iterator member, const Property& property);
  void check_extension(json& extensions, json::iterator member, const Property& property);
  void check_extensions(json& value, Schema schema);
  void list_extensions();
  void check_integer(json& value, double minimum, double maximum);
  void check_index(json& value, const Property& property);
  void check_number(const json& value, double minimum, double maximum);
  void check_index_map(json& value, const Property& property);
  void check_property(json& value, const Property& property);

  json& root_;
  const std::string& file_;
  GltfFaults& faults_;
  std::set<std::string> required_;  // extensions
  std::set<std::string> found_;     // extensions that objects have; not more than a report shows
  json::json_pointer pointer_;
  bool optional_ = false;  // inside an extension that the file does not require
};

}  // namespace emberline::schema
