#include "io/display/display.h"

#include <OpenColorIO/OpenColorIO.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <string_view>

#include "io/display/ocio_config.h"
#include "io/display/working_space.h"
#include "io/files/input_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

namespace ocio = OCIO_NAMESPACE;

// The largest finite half. Display transforms use half values as indices into tables.
constexpr float kMaxHalf = 65504.0f;

// Studio configs have a few megabytes; archives that include their tables have about a hundred.
constexpr uint64_t kMaxConfigBytes = uint64_t(256) << 20;

// Names for "linear light, Rec. 709 primaries, D65" in the ACES configs of OpenColorIO 2 and of
// OpenColorIO 1 (ACES 1.0.3 to 1.2), in Blender's config and in older studio configs.
constexpr std::array kLinearRec709Names = {"Linear Rec.709 (sRGB)",
                                           "lin_rec709_srgb",
                                           "lin_rec709",
                                           "Linear Rec.709",
                                           "Utility - Linear - sRGB",
                                           "Utility - Linear - Rec.709",
                                           "lin_srgb",
                                           "Linear - sRGB"};

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

ocio::BuiltinTransformRcPtr builtin(const char* style, ocio::TransformDirection direction) {
  const ocio::BuiltinTransformRcPtr transform = ocio::BuiltinTransform::Create();
  transform->setStyle(style);
  transform->setDirection(direction);
  return transform;
}

// Converts linear Rec. 709 to ACES2065-1. Uses the same chromatic adaptation as OpenColorIO's own
// matrices (Bradford, D65 to the ACES white).
ocio::GroupTransformRcPtr rec709_to_aces() {
  const ocio::GroupTransformRcPtr group = ocio::GroupTransform::Create();
  group->appendTransform(
      builtin("UTILITY - ACES-AP1_to_LINEAR-REC709_BFD", ocio::TRANSFORM_DIR_INVERSE));
  group->appendTransform(builtin("ACEScg_to_ACES2065-1", ocio::TRANSFORM_DIR_FORWARD));
  return group;
}

// Clamps to [0, 1], then applies the curve of IEC 61966-2-1: slope 12.92 near black, and 1.055
// x^(1/2.4) - 0.055 above.
ocio::GroupTransformRcPtr srgb_curve() {
  const ocio::RangeTransformRcPtr clamp = ocio::RangeTransform::Create();
  clamp->setStyle(ocio::RANGE_CLAMP);
  clamp->setMinInValue(0.0);
  clamp->setMinOutValue(0.0);
  clamp->setMaxInValue(1.0);
  clamp->setMaxOutValue(1.0);
  const ocio::ExponentWithLinearTransformRcPtr curve = ocio::ExponentWithLinearTransform::Create();
  curve->setGamma({2.4, 2.4, 2.4, 1.0});
  curve->setOffset({0.055, 0.055, 0.055, 0.0});
  curve->setDirection(ocio::TRANSFORM_DIR_INVERSE);
  const ocio::GroupTransformRcPtr group = ocio::GroupTransform::Create();
  group->appendTransform(clamp);
  group->appendTransform(curve);
  return group;
}

ocio::GroupTransformRcPtr aces_sdr_on_srgb() {
  const ocio::GroupTransformRcPtr group = rec709_to_aces();
  group->appendTransform(builtin("ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0",
                                 ocio::TRANSFORM_DIR_FORWARD));
  group->appendTransform(builtin("DISPLAY - CIE-XYZ-D65_to_sRGB", ocio::TRANSFORM_DIR_FORWARD));
  return group;
}

void add_space(const ocio::ConfigRcPtr& config, const char* name, bool data,
               const ocio::ConstTransformRcPtr& from_linear_rec709) {
  const ocio::ColorSpaceRcPtr space = ocio::ColorSpace::Create();
  space->setName(name);
  space->setIsData(data);
  if (from_linear_rec709) {
    space->setTransform(from_linear_rec709, ocio::COLORSPACE_DIR_FROM_REFERENCE);
  }
  config->addColorSpace(space);
}

// The reference space of this config is linear Rec. 709.
ocio::ConstConfigRcPtr built_in_config() {
  const ocio::ConfigRcPtr config = ocio::Config::Create();
  config->setMajorVersion(2);
  add_space(config, "lin_rec709", false, nullptr);
  add_space(config, "sRGB", false, srgb_curve());
  add_space(config, "ACES SDR on sRGB", false, aces_sdr_on_srgb());
  add_space(config, "raw", true, nullptr);
  config->setRole(ocio::ROLE_SCENE_LINEAR, "lin_rec709");
  config->setRole(ocio::ROLE_DEFAULT, "raw");
  config->addDisplayView("sRGB", "sRGB", "sRGB", "");
  config->addDisplayView("sRGB", "ACES", "ACES SDR on sRGB", "");
  config->addDisplayView("sRGB", "Raw", "raw", "");
  return config;
}

// Returns the chosen name as the config spells it, or `fallback` if `chosen` is empty. `owner` says
// where the names are defined, for the error message.
std::string find_name(const std::string& kind, const std::string& owner, const std::string& chosen,
                      const std::vector<std::string>& names, const std::string& fallback) {
  if (chosen.empty()) return fallback;
  const auto found = std::ranges::find(names, lower_case(chosen), lower_case);
  if (found != names.end()) return *found;
  throw UsageError("`{0}`: unknown {0} \"{1}\" in {2}; valid names are: {3}", kind,
                   shortened(chosen), owner,
                   names.empty() ? "(none)" : fmt::format("{}", fmt::join(names, ", ")));
}

struct InputSpace {
  std::string space;     // the space in which pixels enter the config
  bool to_aces = false;  // whether pixels are converted to ACES2065-1 first
};

InputSpace find_input_space(const ocio::ConstConfigRcPtr& config, const std::string& place) {
  for (const char* name : kLinearRec709Names) {
    if (const ocio::ConstColorSpaceRcPtr space = config->getColorSpace(name)) {
      return {space->getName(), false};
    }
  }
  if (config->hasRole("aces_interchange")) return {"aces_interchange", true};
  const ocio::ConstColorSpaceRcPtr space = config->getColorSpace(ocio::ROLE_SCENE_LINEAR);
  if (!space) {
    throw InputError(place,
                     "has neither a linear Rec. 709 space nor the roles aces_interchange or "
                     "scene_linear; unset OCIO to use the built-in config");
  }
  log_warning(place +
              ": the OpenColorIO config has no linear Rec. 709 space and no role aces_interchange, "
              "so pixels are assumed to be in " +
              space->getName());
  return {space->getName(), false};
}

// The current config, and its name for messages.
struct CurrentConfig {
  ocio::ConstConfigRcPtr config;
  std::string place;
  bool built_in = false;
  std::vector<std::string> tables = {};  // files that the config refers to
};

CurrentConfig current_config() {
  // OpenColorIO writes to our log. It reports errors by exceptions.
  static std::once_flag logging;
  std::call_once(logging, [] {
    ocio::SetLoggingFunction([](const char* message) { log_verbose(one_line(message)); });
  });
  const char* const variable = std::getenv("OCIO");
  if (!variable || !*variable) {
    return {built_in_config(), "the built-in OpenColorIO config", true};
  }
  // OpenColorIO's own reader would block on a pipe, read a device forever and leak memory on a
  // directory. InputFile checks the path first.
  if (!std::string_view(variable).starts_with("ocio://")) {  // "ocio://" configs are built in
    const InputFile file(variable, "$OCIO");
    if (file.size() > kMaxConfigBytes) {
      throw InputError(variable, "is too large for an OpenColorIO config: {} (named by $OCIO)",
                       readable_bytes(file.size()));
    }
    check_ocio_aliases(file.read_text(), variable);
  }
  try {
    CurrentConfig used{ocio::Config::CreateFromFile(variable), variable};
    used.tables = check_ocio_config(used.config, variable);
    return used;
  } catch (const ocio::Exception& error) {
    throw InputError(variable, one_line(error.what()) + " (named by $OCIO)");
  }
}

void move_to_front(std::vector<std::string>& names, const std::string& first) {
  const auto found = std::ranges::find(names, first);
  if (found != names.end()) std::rotate(names.begin(), found, found + 1);
}

std::vector<std::string> collect_names(int count, const auto& name_of) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.emplace_back(name_of(i));
  return names;
}

std::vector<std::string> views_of(const ocio::ConstConfigRcPtr& config,
                                  const std::string& display) {
  const char* const of = display.c_str();
  return collect_names(config->getNumViews(of), [&](int i) { return config->getView(of, i); });
}

std::vector<std::string> displays_of(const ocio::ConstConfigRcPtr& config) {
  return collect_names(config->getNumDisplays(), [&](int i) { return config->getDisplay(i); });
}

std::vector<std::string> looks_of(const ocio::ConstConfigRcPtr& config) {
  return collect_names(config->getNumLooks(), [&](int i) { return config->getLookNameByIndex(i); });
}

float clamp_to_half(float value) {
  return std::isnan(value) ? 0.0f : std::clamp(value, -kMaxHalf, kMaxHalf);
}

}  // namespace

DisplayNames display_names() {
  const ocio::ConstConfigRcPtr config = current_config().config;
  DisplayNames names;
  std::vector<std::string> displays = displays_of(config);
  move_to_front(displays, config->getDefaultDisplay());
  for (const std::string& display : displays) {
    std::vector<std::string> views = views_of(config, display);
    move_to_front(views, config->getDefaultView(display.c_str()));
    names.displays.push_back({display, std::move(views)});
  }
  names.looks = looks_of(config);
  return names;
}

std::vector<std::string> ocio_table_files() {
  try {
    return current_config().tables;
  } catch (const InputError&) {
    return {};  // code that needs the config reports the error
  }
}

struct DisplayTransform::Impl {
  float scale = 1.0f;                    // 2^exposure
  ToWorkingSpace to_rec709;              // may be null
  ocio::ConstCPUProcessorRcPtr to_aces;  // may be null
  ocio::ConstCPUProcessorRcPtr to_display;
  std::string description;
  bool srgb = false;
};

DisplayTransform::DisplayTransform(const DisplaySettings& settings, WorkingSpace from) {
  if (!std::isfinite(settings.exposure)) throw UsageError("`exposure`: not a finite number");
  // OpenColorIO 2.1 stores the environment variables that it reads in one string for all threads,
  // and a window creates transforms for the screen and for files concurrently.
  static std::mutex ocio_mutex;
  const std::lock_guard lock(ocio_mutex);

  auto impl = std::make_unique<Impl>();
  impl->scale = std::exp2(settings.exposure);
  impl->to_rec709 = from_working_space(from);

  const auto [config, place, built_in, tables] = current_config();
  try {
    const InputSpace source = find_input_space(config, place);

    const std::string display = find_name("display", place, settings.display, displays_of(config),
                                          config->getDefaultDisplay());
    const std::string view =
        find_name("view", "display \"" + shortened(display) + "\"", settings.view,
                  views_of(config, display), config->getDefaultView(display.c_str()));
    const std::string look = find_name("look", place, settings.look, looks_of(config), "");

    const ocio::DisplayViewTransformRcPtr transform = ocio::DisplayViewTransform::Create();
    transform->setSrc(source.space.c_str());
    transform->setDisplay(display.c_str());
    transform->setView(view.c_str());
    const ocio::LegacyViewingPipelineRcPtr pipeline = ocio::LegacyViewingPipeline::Create();
    pipeline->setDisplayViewTransform(transform);
    if (!look.empty()) {
      pipeline->setLooksOverrideEnabled(true);
      pipeline->setLooksOverride(look.c_str());
    }
    // "Lossless" avoids the fast approximations of log and power, which may be wrong in the last of
    // 12 bits and differ between processors.
    impl->to_display = pipeline->getProcessor(config, config->getCurrentContext())
                           ->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);

    const char* const view_space =
        config->getDisplayViewColorSpaceName(display.c_str(), view.c_str());
    const ocio::ConstColorSpaceRcPtr view_color_space =
        config->getColorSpace(view_space ? view_space : "");
    const bool raw = view_color_space && view_color_space->isData();
    if (source.to_aces && !raw) {
      impl->to_aces = config->getProcessor(rec709_to_aces())
                          ->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);
    }
    impl->srgb = !raw && lower_case(display).find("srgb") != std::string::npos;
    impl->description =
        (built_in ? std::string("built-in") : place) + ": " + display + " / " + view;
    if (!look.empty()) impl->description += " / look " + look;
    if (!built_in) impl->description += " (from " + source.space + ")";
  } catch (const ocio::Exception& error) {
    throw InputError(place, one_line(error.what()) + (built_in ? "" : " (named by $OCIO)"));
  } catch (const EmberlineError&) {
    throw;
  } catch (const std::exception& error) {  // an invalid number, which OpenColorIO does not check
    throw InputError(
        place, "OpenColorIO rejects an environment variable (OCIO_...): " + one_line(error.what()));
  }
  impl_ = std::move(impl);
}

DisplayTransform::~DisplayTransform() = default;

void DisplayTransform::apply(float* rgb, size_t pixel_count) const {
  if (pixel_count == 0) return;
  const size_t count = 3 * pixel_count;
  for (size_t i = 0; i < count; ++i) rgb[i] = clamp_to_half(rgb[i] * impl_->scale);
  if (const ColourMatrix* matrix = impl_->to_rec709.get()) {
    for (float* p = rgb; p != rgb + count; p += 3) {
      const Rgb c = *matrix * Rgb(p[0], p[1], p[2]);
      for (int k = 0; k < 3; ++k) p[k] = c[k];
    }
  }
  ocio::PackedImageDesc image(rgb, long(pixel_count), 1, 3);
  if (impl_->to_aces) impl_->to_aces->apply(image);
  impl_->to_display->apply(image);
  for (size_t i = 0; i < count; ++i) rgb[i] = clamp_to_half(rgb[i]);
}

bool DisplayTransform::mixes_channels() const {
  return impl_->to_aces || impl_->to_rec709 || impl_->to_display->hasChannelCrosstalk();
}

std::string DisplayTransform::describe() const { return impl_->description; }

bool DisplayTransform::is_srgb() const { return impl_->srgb; }

}  // namespace emberline
