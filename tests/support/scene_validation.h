// Checks whether a scene that load_gltf returned has the properties that load_gltf guarantees.
#pragma once

#include <string>

#include "io/gltf/materials/material.h"
#include "renderer/core/vector.h"

namespace emberline::test {

// These functions describe a guarantee that an image, a mesh or a scene violates. They return an
// empty string if it violates none.
inline std::string find_scene_violation(const Image& image) {
  const size_t texel = image.type == TexelType::kUint8   ? 1
                       : image.type == TexelType::kFloat ? 4
                                                         : 2;
  if (image.width < 1 || image.height < 1) return "an image without pixels";
  if (image.channels < 1 || image.channels > 4)
    return "an image whose number of channels is not 1 to 4";
  const size_t count = size_t(image.width) * size_t(image.height) * size_t(image.channels);
  return image.texels.size() == count * texel ? "" : "an image with the wrong number of bytes";
}

inline std::string find_scene_violation(const MeshDescription& mesh,
                                        const SceneDescription& scene) {
  const size_t count = mesh.positions.size();
  const auto is_per_vertex = [&](const auto& values) {
    return values.empty() || values.size() == count;
  };
  const auto is_material = [&](int i) { return i >= 0 && size_t(i) < scene.materials.size(); };
  if (mesh.triangles.empty()) return "a mesh without triangles";
  for (const auto& triangle : mesh.triangles) {
    for (const uint32_t v : triangle) {
      if (v >= count) return "a triangle index out of range";
    }
  }
  if (!is_per_vertex(mesh.normals) || !is_per_vertex(mesh.tangents) || !is_per_vertex(mesh.colors))
    return "an attribute without one value per vertex";
  for (const auto& uv : mesh.uv_sets) {
    if (!is_per_vertex(uv)) return "a UV set without one value per vertex";
  }
  for (const Vec3f& p : mesh.positions) {
    if (!is_finite(p)) return "a position that is not finite";
  }
  for (const Vec3f& n : mesh.normals) {
    if (!is_finite(n)) return "a normal that is not finite";
  }
  for (const Vec4f& t : mesh.tangents) {
    if (!is_finite(Vec3f(t.x, t.y, t.z))) return "a tangent that is not finite";
  }
  if (mesh.material != -1 && !is_material(mesh.material))
    return "a mesh's material index out of range";
  for (const VariantMaterial& variant_material : mesh.variant_materials) {
    if (!is_material(variant_material.material)) return "a variant's material index out of range";
    if (variant_material.variant < 0 || size_t(variant_material.variant) >= scene.variants.size())
      return "a variant index out of range";
  }
  return "";
}

inline std::string find_scene_violation(const SceneDescription& scene) {
  for (const InstanceDescription& instance : scene.instances) {
    if (instance.mesh < 0 || size_t(instance.mesh) >= scene.meshes.size())
      return "an instance's mesh index out of range";
    for (int i = 0; i < 16; ++i) {
      if (!std::isfinite(instance.to_world[i / 4][i % 4]))
        return "an instance's transform that is not finite";
    }
  }
  for (const MeshDescription& mesh : scene.meshes) {
    if (const std::string violation = find_scene_violation(mesh, scene); !violation.empty())
      return violation;
  }
  for (const auto& image : scene.images) {
    if (const std::string violation = find_scene_violation(*image); !violation.empty())
      return violation;
  }
  for (const MaterialDescription& m : scene.materials) {
    for (const TextureRef* slot : texture_slots(m)) {
      if (slot->image >= int(scene.images.size())) return "a material's image index out of range";
    }
  }
  return "";
}

}  // namespace emberline::test
