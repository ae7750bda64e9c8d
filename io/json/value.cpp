#include "io/json/value.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace emberline {

JsonValue::JsonValue() : value_(std::make_unique<nlohmann::json>()) {}

JsonValue::JsonValue(nlohmann::json value)
    : value_(std::make_unique<nlohmann::json>(std::move(value))) {}

JsonValue::JsonValue(const JsonValue& other)
    : value_(std::make_unique<nlohmann::json>(*other.value_)) {}

JsonValue::JsonValue(JsonValue&& other) noexcept = default;

JsonValue& JsonValue::operator=(JsonValue other) noexcept {
  value_ = std::move(other.value_);
  return *this;
}

JsonValue::~JsonValue() = default;

}  // namespace emberline
