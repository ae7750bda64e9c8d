#include "io/gltf/document/extensions.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/gltf/document/schema.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/setting_names.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

constexpr std::string_view kSupported[] = {
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
};

// Extensions that are known but ignored, and the reasons that are reported.
constexpr std::pair<std::string_view, std::string_view> kIgnored[] = {
    {"AGI_articulations", "articulations are not supported"},
    {"AGI_stk_metadata", "does not affect the picture"},
    {"CESIUM_primitive_outline", "outlines are not drawn"},
    {"EXT_instance_features", "does not affect the picture"},
    {"EXT_lights_ies", "light profiles are not supported; the lights shine without them"},
    {"EXT_lights_image_based", "not supported; choose an image with `env`"},
    {"EXT_mesh_features", "does not affect the picture"},
    {"EXT_mesh_manifold", "does not affect the triangles"},
    {"EXT_structural_metadata", "does not affect the picture"},
    {"EXT_texture_avif", "AVIF images are not supported; the texture's other image is used"},
    {"KHR_audio_emitter", "sound is not supported"},
    {"KHR_interactivity", "interaction is not supported"},
    {"KHR_node_hoverability", "interaction is not supported"},
    {"KHR_node_selectability", "interaction is not supported"},
    {"KHR_physics_rigid_bodies", "physics is not simulated"},
    {"KHR_gaussian_splatting", "splats are not drawn"},
    {"KHR_gaussian_splatting_compression_spz", "splats are not drawn"},
    {"KHR_gaussian_splatting_compression_spz_2", "splats are not drawn"},
    {"KHR_implicit_shapes", "physics is not simulated"},
    {"KHR_xmp", "does not affect the picture"},
    {"KHR_xmp_json_ld", "does not affect the picture"},
    {"MSFT_lod", "the finest level of detail is rendered"},
    {"MSFT_texture_dds", "DDS images are not supported; the texture's other image is used"},
    {"NV_materials_mdl", "the plain glTF material is used"},
    {"OMI_physics_body", "physics is not simulated"},
    {"OMI_physics_shape", "physics is not simulated"},
    {"VRM", "avatar features are not supported; the plain glTF model is used"},
    {"VRMC_materials_mtoon", "the plain glTF material is used"},
    {"VRMC_springBone", "physics is not simulated"},
    {"VRMC_vrm", "avatar features are not supported; the plain glTF model is used"},
};

std::string with_reason(const std::string& extension) {
  const auto* found =
      std::ranges::find(kIgnored, extension, &std::pair<std::string_view, std::string_view>::first);
  const std::string_view why = found == std::end(kIgnored) ? "unknown extension" : found->second;
  return shortened(extension) + " (" + spell_setting_names(why) + ")";
}

// Adds the text to the list. Returns false if the text is already listed, or if the list is full
// (its last entry then says so). The length is limited because a hostile file may list any number
// of things.
bool add_once(std::vector<std::string>& list, const std::string& text) {
  constexpr size_t kMaxEntries = 100;
  if (std::ranges::find(list, text) != list.end() || list.size() > kMaxEntries) return false;
  list.push_back(list.size() < kMaxEntries ? text : "and more");
  return list.size() <= kMaxEntries;
}

}  // namespace

bool is_supported(std::string_view extension) {
  return std::ranges::find(kSupported, extension) != std::end(kSupported);
}

void check_required_extensions(const GltfDocument& document) {
  size_t i = 0;
  for (const auto& element : document.array("extensionsRequired")) {
    const std::string name = element.get<std::string>();
    if (!is_supported(name)) {
      throw InputError(document.place("/extensionsRequired/" + std::to_string(i)),
                       "the file requires the extension " + shortened(name) +
                           ", which is not supported; export the file without it");
    }
    ++i;
  }
}

void report_ignored(const std::string& file, const std::string& what, CoverageReport& coverage) {
  if (add_once(coverage.ignored, what)) log_warning(file + ": ignored: " + what);
}

void note_approximated(const std::string& what, CoverageReport& coverage) {
  add_once(coverage.approximated, what);
}

void report_approximated(const std::string& file, const std::string& what,
                         CoverageReport& coverage) {
  if (add_once(coverage.approximated, what)) log_warning(file + ": approximated: " + what);
}

void report_unknown_members(const GltfDocument& document, CoverageReport& coverage) {
  const std::string version = document.json->at("asset").at("version").get<std::string>();
  // In version 2.0, unknown members are application data, like extras.
  if (version.find_first_not_of("0.", version.find('.')) == std::string::npos) return;
  for (const std::string& member : unknown_members(*document.json)) {
    report_ignored(
        document.file,
        member + " (the file is glTF " + shortened(version) + ", this version reads 2.0)",
        coverage);
  }
}

void report_extensions(const GltfDocument& document, CoverageReport& coverage) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    for (const auto& element : document.array(list)) {
      const std::string& name = element.get_ref<const std::string&>();
      if (is_supported(name)) {
        add_once(coverage.used, name);
      } else {
        report_ignored(document.file, with_reason(name), coverage);
      }
    }
  }
}

}  // namespace emberline
