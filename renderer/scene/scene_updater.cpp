#include "renderer/scene/scene_updater.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "renderer/core/errors.h"
#include "renderer/lights/environment_light.h"
#include "renderer/scene/flush_emitters.h"
#include "renderer/scene/geometry.h"
#include "renderer/scene/solids.h"

namespace emberline {

using scene_detail::Instance;
using scene_detail::Mesh;

namespace {

template <typename Vector>
uint64_t vector_bytes(const Vector& v) {
  return v.capacity() * sizeof(*v.begin());
}

std::string megabytes(uint64_t bytes) { return fmt::format("{:.1f} MiB", double(bytes) / 1048576); }

// Returns whether the search for flush emitters treats the two emitters alike.
bool same_flush_surfaces(const EmissiveTriangle& a, const EmissiveTriangle& b) {
  return a.instance == b.instance && a.primitive == b.primitive && a.two_sided == b.two_sided &&
         is_black(a.mean_radiance) == is_black(b.mean_radiance);
}

}  // namespace

// Returns for each material whether a placed triangle uses it.
std::vector<bool> SceneUpdater::used_materials() const {
  std::vector<bool> used(description_.materials.size(), false);
  for (const Instance& instance : scene_.instances_) {
    const int material = description_.meshes[instance.mesh].material;
    if (material >= 0 && !scene_.meshes_[instance.mesh].triangles.empty()) {
      used[size_t(material)] = true;
    }
  }
  return used;
}

// Marks what the BVH's filter must read from the mesh at each hit, because an edit may change it.
// Any edit may enable transmission, which makes back faces visible; sidedness and coverage change
// when a variant assigns another material.
void SceneUpdater::mark_editable_filters(Mesh& mesh, const MeshDescription& source) const {
  if (!options_.editable) return;
  const auto mark_for_material = [&](int index) {
    static const MaterialDescription default_material;
    const MaterialDescription& material =
        index < 0 ? default_material : description_.materials[size_t(index)];
    if (!options_.show_backfaces && !material.double_sided) mesh.culling_may_change = true;
    if (material.alpha_mode != AlphaMode::kOpaque && !source.variant_materials.empty()) {
      mesh.coverage_may_change = true;
    }
  };
  mark_for_material(source.material);
  for (const VariantMaterial& other : source.variant_materials) mark_for_material(other.material);
}

void SceneUpdater::reserve_lights(uint64_t count) const {
  // Covers the light, its light BVH node with build data, and its points in the flush emitter
  // search.
  constexpr uint64_t kLightBytes = 400;
  progress_.budget()->reserve(MemoryPart::kLights, bytes_of(count, kLightBytes), description_.file);
}

void SceneUpdater::assign_materials() {
  progress_.budget()->reserve(MemoryPart::kTextures,
                              bytes_of(description_.materials.size(), sizeof(Material)),
                              description_.file);
  auto materials = std::make_unique<MaterialSet>(description_, used_materials());
  previous_materials_ = std::exchange(scene_.materials_, std::move(materials));
  emission_changed_.assign(scene_.meshes_.size(), false);
  scene_.has_coverage_ = false;
  scene_.is_transmissive_ = false;
  scene_.has_smooth_walls_ = scene_.has_smooth_solids_ = false;
  for (const Instance& instance : scene_.instances_) {
    Mesh& mesh = scene_.meshes_[instance.mesh];
    const MeshDescription& source = description_.meshes[instance.mesh];
    const int index = source.material;
    const Material& material = (*scene_.materials_)[index];
    if (!mesh.material) mark_editable_filters(mesh, source);
    if (!mesh.material || !mesh.material->has_same_emission(material))
      emission_changed_[instance.mesh] = true;
    mesh.material = &material;
    mesh.material_index = uint32_t(index < 0 ? int(description_.materials.size()) : index);
    mesh.has_attributes = material.reads_attributes(!mesh.colors.empty()) ||
                          (options_.unread_uv && !mesh.uv_sets.empty());
    const bool single_sided = !options_.show_backfaces && !material.double_sided();
    mesh.cull_backfaces = single_sided && !material.is_transmissive();
    mesh.has_coverage = material.has_alpha(!mesh.colors.empty());
    if (mesh.has_coverage) scene_.has_coverage_ = true;
    if (material.is_transmissive()) scene_.is_transmissive_ = true;
    if (material.is_smooth_wall()) scene_.has_smooth_walls_ = true;
    if (material.is_smooth_solid()) scene_.has_smooth_solids_ = true;
  }
}

void SceneUpdater::find_solids() {
  scene_.solids_ = scene_.is_transmissive_ && options_.bvh
                       ? Solids::find(scene_, description_, progress_)
                       : nullptr;
}

bool SceneUpdater::emitters_changed() const {
  return !scene_.lights_ || std::ranges::find(emission_changed_, true) != emission_changed_.end();
}

void SceneUpdater::reuse_from(const Scene& before, const std::vector<uint32_t>& from) {
  previous_scene_ = &before;
  previous_mesh_indices_ = from;
  previous_first_emitters_.assign(from.size(), Scene::kNoEmitter);
  std::vector<uint32_t> first(before.meshes_.size(), Scene::kNoEmitter);
  for (const Instance& instance : before.instances_) first[instance.mesh] = instance.first_emitter;
  for (size_t i = 0; i < from.size(); ++i) {
    if (from[i] != kNone) previous_first_emitters_[i] = first[from[i]];
  }
  scene_.environment_ = before.environment_;
}

// Returns the previous emitters of the same mesh, possibly of another instance, if its emission is
// unchanged; otherwise null.
const EmissiveTriangle* SceneUpdater::previous_emitters(uint32_t mesh) const {
  if (!previous_scene_ || previous_first_emitters_[mesh] == Scene::kNoEmitter) return nullptr;
  const Material& previous_material =
      *previous_scene_->meshes_[previous_mesh_indices_[mesh]].material;
  if (!previous_material.has_same_emission(*scene_.meshes_[mesh].material)) return nullptr;
  return &previous_scene_->lights_->triangles()[previous_first_emitters_[mesh]];
}

void SceneUpdater::collect_emitters_of(uint32_t i, std::vector<EmissiveTriangle>& triangles) {
  const Instance& instance = scene_.instances_[i];
  const Mesh& mesh = scene_.meshes_[instance.mesh];
  const Material& material = *mesh.material;
  const EmissiveTriangle* const previous = previous_emitters(instance.mesh);
  for (uint32_t p = 0; p < mesh.triangles.size(); ++p) {
    if (p % 16 == 0) progress_.check();  // a mean takes microseconds, in the worst case 40 ms
    const std::array<Vec3d, 3> corners = scene_detail::placed_corners(mesh, instance, p);
    EmissiveTriangle t;
    t.p0 = to_float(corners[0]);
    t.p1 = to_float(corners[1]);
    t.p2 = to_float(corners[2]);
    if (instance.mirrored) std::swap(t.p1, t.p2);
    using scene_detail::interpolate_attributes;
    t.mean_radiance = previous
                          ? previous[p].mean_radiance
                          : material.mean_emission(interpolate_attributes(mesh, p, 0.0f, 0.0f),
                                                   interpolate_attributes(mesh, p, 1.0f, 0.0f),
                                                   interpolate_attributes(mesh, p, 0.0f, 1.0f));
    t.moves = scene_detail::moves(mesh, instance);
    t.has_visibility_times = !scene_.visibility_.empty() && scene_.visibility_[i];
    t.two_sided = material.double_sided() || material.is_transmissive() || options_.show_backfaces;
    t.instance = i;
    t.primitive = p;
    triangles.push_back(t);
  }
}

std::vector<EmissiveTriangle> SceneUpdater::collect_emitters() {
  size_t total = 0;
  for (const Instance& instance : scene_.instances_) {
    const Mesh& mesh = scene_.meshes_[instance.mesh];
    if (mesh.material->is_emissive()) total += mesh.triangles.size();
  }
  // The light BVH numbers its nodes with 30 bits.
  if (total >= size_t(1) << 30) {
    throw InputError(
        description_.file,
        "the scene has 2^30 or more emissive triangles; make fewer surfaces emit light");
  }
  reserve_lights(total);
  std::vector<EmissiveTriangle> triangles;
  triangles.reserve(total);
  progress_.begin(LoadStage::kLights, total);
  for (uint32_t i = 0; i < scene_.instances_.size(); ++i) {
    Instance& instance = scene_.instances_[i];
    const Mesh& mesh = scene_.meshes_[instance.mesh];
    const uint32_t before = std::exchange(instance.first_emitter, Scene::kNoEmitter);
    if (!mesh.material->is_emissive()) continue;
    instance.first_emitter = uint32_t(triangles.size());
    if (emission_changed_[instance.mesh]) {
      collect_emitters_of(i, triangles);
    } else {  // unchanged emission: reuse the mean over each triangle
      const auto old = scene_.lights_->triangles().begin() + before;
      triangles.insert(triangles.end(), old, old + std::ptrdiff_t(mesh.triangles.size()));
    }
    progress_.advance(mesh.triangles.size());
  }
  return triangles;
}

PointLight SceneUpdater::place_light(const PunctualLightDescription& source) const {
  PointLight light;
  const bool directional = source.type == PunctualType::kDirectional;
  const auto place = [&](const Mat44d& m) -> PointLightPlace {
    PointLightPlace placed{to_float((row(m, 3) - scene_.origin_) * scene_.scale_),
                           normalize_or(to_float(-row(m, 2)), Vec3f(0, 0, -1))};
    if (!directional && !(double(max_abs_component(placed.position)) <= scene_.max_origin_)) {
      throw InputError(description_.file,
                       "light '" + source.name + "' is too far from the scene to trace rays to it");
    }
    return placed;
  };
  static_cast<PointLightPlace&>(light) = place(source.to_world);
  for (const Mat44d& step : source.motion) light.motion.push_back(place(step));
  // Internal intensity over squared internal distance must equal world intensity over squared world
  // distance.
  light.intensity = converted(description_.to_working, source.intensity) *
                    (directional ? 1.0f : float(scene_.scale_ * scene_.scale_));
  light.share = converted(description_.to_working, source.share, source.intensity);
  light.visibility = source.visibility;
  if (directional) {
    light.type = PointLightType::kDirectional;
  } else {
    light.type =
        source.type == PunctualType::kSpot ? PointLightType::kSpot : PointLightType::kPoint;
    light.cos_inner = std::cos(source.inner_cone);
    light.cos_outer = std::cos(source.outer_cone);
    light.cones = source.cones;
    light.range = float(double(source.range) * scene_.scale_);
    light.range_scale = source.range_scale;
  }
  return light;
}

// Sets the environment. An environment that keeps its image is only adjusted in place. Returns
// whether the light sampler must be rebuilt.
bool SceneUpdater::set_environment() {
  std::shared_ptr<EnvironmentLight>& light = scene_.environment_;
  const EnvironmentLight* before = light.get();
  const bool was_lit = light && !light->black();
  if (const auto& e = description_.environment) {
    const EnvironmentLightSettings settings{.sun = e->sun.get(),
                                            .to_working = description_.to_working.get()};
    if (!e->image) {
      light = std::make_shared<EnvironmentLight>(e->constant, settings);
    } else if (!light || light->image() != e->image.get()) {
      progress_.budget()->reserve(MemoryPart::kLights, EnvironmentLight::table_bytes(*e->image),
                                  e->file);
      light = std::make_shared<EnvironmentLight>(e->image, 1.0f, 0.0f, settings);
    }
    light->adjust({e->strength, e->tint, e->rotation_degrees});
  } else {
    light.reset();
  }
  return light.get() != before || was_lit != (light && !light->black());
}

void SceneUpdater::build_lights() {
  progress_.begin(LoadStage::kLights);
  reserve_lights(description_.lights.size());
  std::vector<PointLight> points;
  points.reserve(description_.lights.size());
  for (const PunctualLightDescription& light : description_.lights) {
    if (shines(light)) points.push_back(place_light(light));
  }
  const bool is_environment_replaced = set_environment();
  const bool are_emitters_outdated = emitters_changed();
  if (are_emitters_outdated || is_environment_replaced || points != scene_.lights_->points()) {
    std::vector<EmissiveTriangle> before;
    if (scene_.lights_) before = scene_.lights_->triangles();
    LightSampler lights(are_emitters_outdated ? collect_emitters() : std::move(before),
                        std::move(points), scene_.environment_, &scene_.emitter_motion());
    if (scene_.lights_) {
      *scene_.lights_ = std::move(lights);  // in place, because flush_ refers to its triangles
    } else {
      scene_.lights_ = std::make_unique<LightSampler>(std::move(lights));
    }
    if (are_emitters_outdated) find_flush_emitters(before);
  }
  scene_.moves_ = has_motion();
  if (!options_.editable && scene_.environment_ && scene_.environment_->black()) {
    scene_.environment_.reset();
  }
}

void SceneUpdater::find_flush_emitters(const std::vector<EmissiveTriangle>& before) {
  if (!options_.bvh) return;  // FlushEmitters needs the scene's Embree device
  const std::vector<EmissiveTriangle>& triangles = scene_.lights_->triangles();
  if (std::ranges::equal(before, triangles, same_flush_surfaces)) return;
  scene_.flush_ = scene_detail::FlushEmitters::find(
      {scene_.meshes_, scene_.instances_, scene_.visibility_, triangles}, *scene_.geometry_,
      progress_);
  scene_.geometry_->device()->check();
}

void SceneUpdater::update_memory_and_features() {
  scene_.memory_ = {};
  SceneMemory& memory = scene_.memory_;
  bool culls = false, masks = false, blends = false;
  memory.geometry_bytes += vector_bytes(scene_.meshes_);
  for (const Mesh& mesh : scene_.meshes_) {
    memory.geometry_bytes += allocated_bytes(mesh);
    if (mesh.record) memory.geometry_bytes += sizeof(scene_detail::GeometryRecord);
    if (mesh.triangles.empty()) continue;
    culls = culls || mesh.cull_backfaces;
    if (!mesh.has_coverage) continue;
    (mesh.material->alpha_mode() == AlphaMode::kMask ? masks : blends) = true;
  }
  memory.geometry_bytes += vector_bytes(scene_.instances_) + vector_bytes(scene_.next_frame_) +
                           vector_bytes(scene_.visibility_);
  if (scene_.geometry_) {
    memory.bvh_bytes = scene_.geometry_->device()->bytes();
  }
  memory.texture_bytes = scene_.materials_->bytes();
  memory.texture_file_bytes = scene_.materials_->texture_file_bytes();
  if (scene_.environment_) memory.texture_bytes += scene_.environment_->bytes();
  memory.geometry_bytes += scene_.lights_->bytes();
  list_features(culls, masks, blends);
}

bool SceneUpdater::has_motion() const {
  const auto moves = [this](const Instance& instance) {
    const Mesh& mesh = scene_.meshes_[instance.mesh];
    return scene_detail::moves(mesh, instance) || mesh.material->is_emission_animated();
  };
  return !scene_.visibility_.empty() || std::ranges::any_of(scene_.instances_, moves) ||
         std::ranges::any_of(scene_.lights_->points(), &PointLight::is_animated);
}

void SceneUpdater::list_motion() {
  const auto list = [&](auto count, const char* text) {
    if (count > 0) scene_.features_.push_back(fmt::format(fmt::runtime(text), count));
  };
  const auto instances = [&](const auto& matches) {
    return std::ranges::count_if(scene_.instances_, [&](const Instance& instance) {
      return matches(scene_.meshes_[instance.mesh], instance);
    });
  };
  const auto lights = [&](const auto& matches) {
    return std::ranges::count_if(scene_.lights_->points(), matches);
  };
  list(instances([](const Mesh& m, const Instance& i) { return scene_detail::moves(m, i); }),
       "motion ({} instances)");
  list(lights([](const PointLight& light) { return !light.motion.empty(); }),
       "motion ({} point lights)");
  list(scene_.next_frame_.size(), "motion vectors ({} instances move until the next frame)");
  list(std::ranges::count_if(scene_.visibility_,
                             [](const auto& visibility) { return visibility != nullptr; }),
       "visibility ({} instances appear or disappear)");
  list(instances([](const Mesh& m, const Instance&) { return m.material->is_emission_animated(); }),
       "animated emission ({} instances)");
  list(lights(
           [](const PointLight& l) { return l.share || l.cones || l.range_scale || l.visibility; }),
       "animated light ({} point lights)");
}

void SceneUpdater::list_features(bool culls, bool masks, bool blends) {
  std::vector<std::string>& features = scene_.features_;
  features.clear();
  if (scene_.origin_ != Vec3d(0.0)) {
    features.push_back(fmt::format("rebasing (origin {:.6g}, {:.6g}, {:.6g})", scene_.origin_.x,
                                   scene_.origin_.y, scene_.origin_.z));
  }
  if (scene_.scale_ != 1.0) features.push_back(fmt::format("rescaling (x {:.6g})", scene_.scale_));
  const auto instanced = std::ranges::count_if(scene_.instances_, [&](const Instance& instance) {
    return instance.transformed && !scene_.meshes_[instance.mesh].triangles.empty();
  });
  if (instanced > 0) features.push_back(fmt::format("instancing ({} instances)", instanced));
  list_motion();
  if (const auto& e = description_.environment) {
    features.push_back(
        e->image ? fmt::format("environment map ({} x {})", e->image->width, e->image->height)
                 : std::string("constant environment"));
    if (e->sun) features.push_back("sun");
  }
  if (!scene_.lights_->empty()) features.push_back("lights: " + scene_.lights_->describe());
  if (scene_.flush_) {
    features.push_back(
        fmt::format("flush emitters ({} triangles lie in another surface)", scene_.flush_->size()));
  }
  if (scene_.solids_ && scene_.solids_->touching_faces() > 0) {
    features.push_back(fmt::format("touching solids ({} faces lie in a face of another solid)",
                                   scene_.solids_->touching_faces()));
  }
  if (culls) features.emplace_back("back-face culling (single-sided materials)");
  if (masks || blends) {
    features.push_back(fmt::format("alpha coverage ({})", masks && blends ? "mask, blend"
                                                          : masks         ? "mask"
                                                                          : "blend"));
  }
  for (const std::string& feature : scene_.materials_->features()) features.push_back(feature);
  features.push_back(
      fmt::format("BVH, {} triangles placed{}", scene_.triangle_count_,
                  options_.bvh ? fmt::format(" ({})", megabytes(scene_.memory_.bvh_bytes)) : ""));
}

}  // namespace emberline
