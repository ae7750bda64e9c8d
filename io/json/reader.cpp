#include "io/json/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"
#include "renderer/core/names.h"

namespace emberline {

using nlohmann::json;

JsonReader JsonReader::member(const std::string& name, const json& value) const {
  return {value, file_, pointer_ + (json::json_pointer() / name).to_string()};
}

const JsonReader& JsonReader::object(std::span<const std::string_view> members) const {
  if (!json_.is_object()) throw_expected("an object");
  for (const auto& [name, value] : json_.items()) {
    if (std::ranges::find(members, name) != members.end()) continue;
    throw InputError(member(name, value).place(), unknown_name_message("member", name, members));
  }
  return *this;
}

bool JsonReader::has(const char* member) const { return json_.contains(member); }

JsonReader JsonReader::operator[](const std::string& name) const {
  if (!json_.is_object()) throw_expected("an object");
  const auto found = json_.find(name);
  if (found == json_.end()) {
    throw InputError(place(), "the required member \"{}\" is missing", name);
  }
  return member(name, *found);
}

std::vector<std::string> JsonReader::members() const {
  if (!json_.is_object()) throw_expected("an object");
  std::vector<std::string> names;
  for (const auto& [name, value] : json_.items()) names.push_back(name);
  return names;
}

size_t JsonReader::size() const {
  if (!json_.is_array()) throw_expected("an array");
  return json_.size();
}

JsonReader JsonReader::operator[](size_t element) const {
  return member(std::to_string(element), json_.at(element));
}

bool JsonReader::is_null() const { return json_.is_null(); }

double JsonReader::number(double minimum, double maximum) const {
  const double value = json_.is_number() ? json_.get<double>() : std::nan("");
  if (!(value >= minimum && value <= maximum)) {
    throw_expected(fmt::format("a number from {} to {}", minimum, maximum));
  }
  return value;
}

uint64_t JsonReader::whole_number(uint64_t minimum, uint64_t maximum) const {
  if (!json_.is_number_unsigned() || json_ < minimum || json_ > maximum) {
    throw_expected(fmt::format("a whole number from {} to {}", minimum, maximum));
  }
  return json_.get<uint64_t>();
}

bool JsonReader::boolean() const {
  if (!json_.is_boolean()) throw_expected("true or false");
  return json_.get<bool>();
}

std::string JsonReader::text() const {
  if (!json_.is_string()) throw_expected("a string");
  return json_.get<std::string>();
}

Vec3d JsonReader::vector(double minimum, double maximum) const {
  if (!json_.is_array() || json_.size() != 3) throw_expected("an array of 3 numbers");
  const auto component = [&](size_t i) { return (*this)[i].number(minimum, maximum); };
  return {component(0), component(1), component(2)};
}

void JsonReader::throw_expected(const std::string& what) const {
  constexpr size_t kMaxLength = 40;
  std::string found = json_.dump(-1, ' ', false, json::error_handler_t::replace);
  if (found.size() > kMaxLength) found = found.substr(0, kMaxLength - 3) + "...";
  throw InputError(place(), "expected {}, found {}", what, found);
}

}  // namespace emberline
