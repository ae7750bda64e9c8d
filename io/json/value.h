// A JSON value as a member of a class. nlohmann/json.hpp, which takes long to compile, is included
// by the sources that look into the value.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>

namespace emberline {

// Copied with its value. One that was moved from may be assigned to, and nothing else.
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
