#include "io/gltf_extensions.h"

#include <algorithm>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using enum ExtensionSupport;

constexpr ExtensionInfo kExtensions[] = {
    {"EXT_mesh_gpu_instancing", kHonoured, ""},
    {"EXT_meshopt_compression", kHonoured, ""},
    {"EXT_texture_webp", kHonoured, ""},
    {"KHR_animation_pointer", kHonoured, ""},
    {"KHR_draco_mesh_compression", kHonoured, ""},
    {"KHR_lights_punctual", kHonoured, ""},
    {"KHR_materials_anisotropy", kHonoured, ""},
    {"KHR_materials_clearcoat", kHonoured, ""},
    {"KHR_materials_diffuse_transmission", kHonoured, ""},
    {"KHR_materials_dispersion", kHonoured, ""},
    {"KHR_materials_emissive_strength", kHonoured, ""},
    {"KHR_materials_ior", kHonoured, ""},
    {"KHR_materials_iridescence", kHonoured, ""},
    {"KHR_materials_pbrSpecularGlossiness", kHonoured, ""},
    {"KHR_materials_sheen", kHonoured, ""},
    {"KHR_materials_specular", kHonoured, ""},
    {"KHR_materials_transmission", kHonoured, ""},
    {"KHR_materials_unlit", kHonoured, ""},
    {"KHR_materials_variants", kHonoured, ""},
    {"KHR_materials_volume", kHonoured, ""},
    {"KHR_mesh_quantization", kHonoured, ""},
    {"KHR_meshopt_compression", kHonoured, ""},
    {"KHR_node_visibility", kHonoured, ""},
    {"KHR_texture_basisu", kHonoured, ""},
    {"KHR_texture_transform", kHonoured, ""},
};

// False: it is there already, or the list is full, which its last entry says. A hostile file may
// name any number of things.
bool add_once(std::vector<std::string>& list, const std::string& text) {
  constexpr size_t kLongest = 100;
  if (std::ranges::find(list, text) != list.end() || list.size() > kLongest) return false;
  list.push_back(list.size() < kLongest ? text : "more that is not listed");
  return list.size() <= kLongest;
}

}  // namespace

const ExtensionInfo* find_extension_info(std::string_view name) {
  const auto* found = std::find_if(std::begin(kExtensions), std::end(kExtensions),
                                   [&](const ExtensionInfo& info) { return info.name == name; });
  return found == std::end(kExtensions) ? nullptr : found;
}

void check_required_extensions(const GltfDocument& document) {
  size_t i = 0;
  for (const auto& element : document.array("extensionsRequired")) {
    const std::string name = element.get<std::string>();
    const ExtensionInfo* info = find_extension_info(name);
    if (!info || info->support == kIgnored) {
      throw InputError(document.place("/extensionsRequired/" + std::to_string(i)),
                       "the file requires the extension " + shortened(name) +
                           ", which is not supported; export it without");
    }
    ++i;
  }
}

void report_ignored(const std::string& file, const std::string& what, CoverageReport& coverage) {
  if (add_once(coverage.ignored, what)) log_warning(file + ": ignored: " + what);
}

void report_approximated(const std::string& file, const std::string& what,
                         CoverageReport& coverage) {
  if (add_once(coverage.approximated, what)) log_warning(file + ": approximated: " + what);
}

void report_extensions(const GltfDocument& document, CoverageReport& coverage) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    for (const auto& element : document.array(list)) {
      const std::string& name = element.get_ref<const std::string&>();
      const ExtensionInfo* info = find_extension_info(name);
      if (info && info->support == kHonoured) {
        add_once(coverage.used, name);
        continue;
      }
      const std::string text =
          info ? name + " (" + std::string(info->remark) + ")" : shortened(name);
      if (info && info->support != kIgnored) {
        report_approximated(document.file, text, coverage);
      } else if (add_once(coverage.ignored, name)) {
        log_warning(document.file + ": ignored: " + text);
      }
    }
  }
}

}  // namespace emberline
