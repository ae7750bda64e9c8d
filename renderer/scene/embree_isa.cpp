#include "renderer/scene/embree_isa.h"

#include <array>

#include "renderer/scene/geometry.h"

namespace emberline {
namespace {

using enum EmbreeIsa;

#ifdef __aarch64__
constexpr std::array<NamedValue<EmbreeIsa>, 1> kIsas = {{{"neon", "every 64-bit ARM", kNeon}}};
#else
constexpr std::array<NamedValue<EmbreeIsa>, 3> kIsas = {{
    {"sse4.2", "every x86-64 processor of the last 15 years", kSse42},
    {"avx2", "Intel since 2013, AMD since 2015", kAvx2},
    {"avx512", "Intel servers, AMD since 2022", kAvx512},
}};
#endif

bool processor_has(EmbreeIsa isa) {
#ifdef __x86_64__
  __builtin_cpu_init();
  switch (isa) {
    case kSse42:
      return true;
    case kAvx2:
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
             __builtin_cpu_supports("bmi2");
    case kAvx512:
      return processor_has(kAvx2) && __builtin_cpu_supports("avx512f") &&
             __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    case kNeon:
      return false;
  }
#endif
  return isa == kNeon;
}

// Returns whether Embree was built with these kernels. Also returns true if no device can be
// created, so that a later error explains the failure.
bool embree_has(EmbreeIsa isa) {
  const RTCDevice device = scene_detail::new_device(isa);
  if (!device) return true;
  const auto has = [&](RTCDeviceProperty property) {
    return rtcGetDeviceProperty(device, property) != 0;
  };
  const bool is_supported = isa == kAvx512 ? has(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)
                            : isa == kAvx2 ? has(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)
                                           : true;
  rtcReleaseDevice(device);
  return is_supported;
}

}  // namespace

std::string embree_version() {
  const RTCDevice device = scene_detail::new_device(kIsas.front().value);
  if (!device) return "unknown";
  std::string version;
  for (const RTCDeviceProperty part :
       {RTC_DEVICE_PROPERTY_VERSION_MAJOR, RTC_DEVICE_PROPERTY_VERSION_MINOR,
        RTC_DEVICE_PROPERTY_VERSION_PATCH}) {
    if (!version.empty()) version += '.';
    version += std::to_string(rtcGetDeviceProperty(device, part));
  }
  rtcReleaseDevice(device);
  return version;
}

std::span<const NamedValue<EmbreeIsa>> embree_isa_table() { return kIsas; }

EmbreeIsa widest_isa() {
  static const EmbreeIsa widest = [] {
    size_t i = kIsas.size() - 1;
    while (i > 0 && !(processor_has(kIsas[i].value) && embree_has(kIsas[i].value))) --i;
    return kIsas[i].value;
  }();
  return widest;
}

}  // namespace emberline
