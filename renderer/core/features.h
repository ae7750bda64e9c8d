// What this program is built with. The program that people run has everything; a scene pays only
// for what it uses (law 3), and the benchmark that shows it (tests/bench/README.md, "What is
// unused") compares it with one built for plain scenes alone (cmake -DEMBERLINE_PLAIN=ON): opaque,
// without textures, vertex colours, instances, point lights, environment, lens, light BVH, AOVs or
// light groups.
//
// A feature is switched off where its data is declared, with the types below: they hold nothing and
// say "no" at compile time, so that the code that asks them is left out without being touched.
#pragma once

#include <cassert>
#include <cstddef>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "renderer/core/zeroed_array.h"

namespace emberline::features {

#ifdef EMBERLINE_PLAIN
inline constexpr bool kAll = false;
#else
inline constexpr bool kAll = true;
#endif
inline constexpr bool kTextures = kAll;  // and what only they need: UV sets, tangents, normal maps
inline constexpr bool kVertexColors = kAll;
inline constexpr bool kCoverage = kAll;
inline constexpr bool kTransmission = kAll;
inline constexpr bool kUnlit = kAll;
inline constexpr bool kInstances = kAll;
inline constexpr bool kPointLights = kAll;  // directional and spot lights as well
inline constexpr bool kEnvironment = kAll;
inline constexpr bool kLightBvh = kAll;
inline constexpr bool kAovs = kAll;
inline constexpr bool kLightGroups = kAll;
inline constexpr bool kOrthographic = kAll;
inline constexpr bool kLens = kAll;

namespace detail {

// False for ever. Giving it `true` is the mistake of whoever let the scene in.
struct NoFlag {
  constexpr NoFlag() = default;
  constexpr NoFlag(bool value) { assert(!value), static_cast<void>(value); }
  constexpr operator bool() const { return false; }
};

// Takes any value and keeps none: in the place of a T that always is T's value `kValue`.
template <typename T, float kValue>
struct NoValue {
  static constexpr float x = kValue, y = kValue, z = kValue, w = kValue;
  constexpr NoValue() = default;
  NoValue(const T&) {}
  operator T() const { return T(kValue, kValue, kValue, kValue); }
};

// Empty for ever. The elements asked for in code that is never reached do not exist.
template <typename T>
struct NoVector {
  NoVector() = default;
  NoVector(const std::vector<T>& values) { assert(values.empty()), static_cast<void>(values); }
  constexpr bool empty() const { return true; }
  constexpr size_t size() const { return 0; }
  constexpr size_t capacity() const { return 0; }
  void assign(size_t, const T&) {}
  void reset(size_t) {}
  void push_back(const T&) {}
  T* begin() const { return nullptr; }
  T* end() const { return nullptr; }
  [[noreturn]] T& operator[](size_t) const { __builtin_unreachable(); }
};

// Null for ever.
template <typename T>
struct NoPointer {
  NoPointer() = default;
  template <typename P>
  NoPointer(P&& pointer) {
    assert(!pointer), static_cast<void>(pointer);
  }
  constexpr explicit operator bool() const { return false; }
  constexpr bool operator==(std::nullptr_t) const { return true; }
  T* get() const { return none_; }
  [[noreturn]] T* operator->() const { __builtin_unreachable(); }
  [[noreturn]] T& operator*() const { __builtin_unreachable(); }
  template <typename... Arguments>
  void emplace(Arguments&&...) {}

 private:
  static constexpr T* none_ = nullptr;
};

}  // namespace detail

template <bool kBuilt>
using Flag = std::conditional_t<kBuilt, bool, detail::NoFlag>;
template <bool kBuilt, typename T, float kValue>
using Value = std::conditional_t<kBuilt, T, detail::NoValue<T, kValue>>;
template <bool kBuilt, typename T>
using Vector = std::conditional_t<kBuilt, std::vector<T>, detail::NoVector<T>>;
template <bool kBuilt, typename T>
using Zeroed = std::conditional_t<kBuilt, ZeroedArray<T>, detail::NoVector<T>>;
template <bool kBuilt, typename T>
using Pointer = std::conditional_t<kBuilt, T*, detail::NoPointer<T>>;
template <bool kBuilt, typename T>
using SharedPointer = std::conditional_t<kBuilt, std::shared_ptr<T>, detail::NoPointer<T>>;
template <bool kBuilt, typename T>
using UniquePointer = std::conditional_t<kBuilt, std::unique_ptr<T>, detail::NoPointer<T>>;
template <bool kBuilt, typename T>
using Optional = std::conditional_t<kBuilt, std::optional<T>, detail::NoPointer<T>>;

}  // namespace emberline::features
