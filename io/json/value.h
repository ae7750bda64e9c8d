// A JSON value that can be a class member without including nlohmann/json.hpp, which is slow to
// compile. Only the sources that use the value include that header.
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
