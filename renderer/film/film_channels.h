// The channels of a film, by name.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/names.h"

namespace emberline {

// Channels beside R G B A and `samples`, made only when asked for.
enum class Aov : uint8_t {
  kVariance,
  kAlbedo,
  kNormal,
  kDepth,
  kPosition,
  kUv,
  kVelocity,
  kClamped,
  kDirect,  // as in PathLayer
  kIndirect,
  kEmission,
  kTransmission,
  kReflection,
  kEnvironment,
  kShadow,
  kDenoising,
  kId,
  kTime,
  kStop,
  kNonFinite,
  kPart,
};

// The table behind --aov, its --help and its error message.
std::span<const NamedValue<Aov>> aov_table();

class AovSet {
 public:
  void insert(Aov aov) { bits_ |= bit(aov); }
  bool contains(Aov aov) const { return (bits_ & bit(aov)) != 0; }
  bool empty() const { return bits_ == 0; }
  // "variance,N" -> set. Throws UsageError that lists the valid names.
  static AovSet parse(std::string_view list);

 private:
  static constexpr uint32_t bit(Aov aov) { return 1u << static_cast<uint32_t>(aov); }
  uint32_t bits_ = 0;
};

struct FilmChannel {
  std::string name;
  bool integer = false;
};
// R G B A samples, then the AOVs in table order.
std::vector<FilmChannel> film_channels(const AovSet& aovs);
std::vector<std::string> film_channel_names(const AovSet& aovs);

}  // namespace emberline
