// A JSON value as a class member. nlohmann/json.hpp is slow to compile, so only the sources that
// look into the value include it.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>

namespace emberline {

// Copies deeply. A moved-from value may only be assigned to or destroyed.
class JsonValue {
 public:
  JsonValue();  // null
  explicit JsonValue(nlohmann::json value);
  JsonValue(const JsonValue& other);
  JsonValue(JsonValue&& other) noexcept;
  JsonValue& operator=(JsonValue other) noexcept;
  ~JsonValue();

  nlohmann::json& operator*() { return *value_; }
  const nlohmann::json& operator*() const { return *value_; }
  nlohmann::json* operator->() { return value_.get(); }
  const nlohmann::json* operator->() const { return value_.get(); }

 private:
  std::unique_ptr<nlohmann::json> value_;
};

}  // namespace emberline
