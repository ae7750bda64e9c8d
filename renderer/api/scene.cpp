// Opens, poses and edits scenes.
#include <tbb/task_arena.h>

#include <cmath>
#include <span>
#include <utility>

#include "io/files/fingerprint.h"
#include "io/json/edits_file.h"
#include "renderer/api/access.h"
#include "renderer/core/errors.h"
#include "renderer/description/edits_template.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/render_plan.h"

namespace emberline::api {
namespace {

template <typename List>
std::vector<std::string> names_of(const List& list) {
  std::vector<std::string> names;
  for (const auto& entry : list) names.push_back(entry.name);
  return names;
}

std::shared_ptr<const Image> image_of(const Scene::Environment& environment) {
  const int width = environment.width, height = environment.height;
  if (width <= 0 || height <= 0)
    throw emberline::UsageError("environment: the picture has no texels");
  auto image = std::make_shared<Image>();
  image->name = "the environment";
  image->width = width;
  image->height = height;
  image->channels = 3;
  image->type = TexelType::kFloat;
  const size_t count = 3 * size_t(width) * size_t(height);
  for (size_t i = 0; i < count; ++i) {
    const float value = environment.rgb[i];
    if (std::isfinite(value) && value >= 0.0f) continue;
    const size_t texel = i / 3;
    throw emberline::UsageError(
        "environment: the value {} at column {} of row {} is negative or not finite", value,
        texel % size_t(width), texel / size_t(width));
  }
  const auto bytes = std::as_bytes(std::span(environment.rgb, count));
  image->texels.assign(bytes.begin(), bytes.end());
  return image;
}

// Returns the text by which checkpoints identify the edits.
std::string fingerprint_of(std::string_view json, const SceneEdits& edits) {
  const uint64_t text = fingerprint(json);
  if (!edits.environment.image) return hexadecimal(text);
  const std::vector<std::byte>& texels = edits.environment.image->texels;
  return hexadecimal(
      fingerprint({reinterpret_cast<const char*>(texels.data()), texels.size()}, text));
}

}  // namespace

Scene::State::State(const std::string& path, const Settings& initial_settings,
                    const Resources& given_resources, const std::stop_token& stop, bool poses)
    : resources(given_resources), settings(Access::impl(initial_settings)) {
  check_resources(resources);
  settings.scene = path;
  limits = limits_of({resources.memory_bytes, resources.load_timeout_s}, path);
  build = RenderPlan(settings).build;
  build.editable = true;
  LoadProgress progress({}, stop, limits);
  FrameSettings load_settings = settings;
  load_settings.light_groups = false;  // each frame creates them, because they depend on edits
  files = LoadedFiles(settings, progress);
  tbb::task_arena(arena_threads(resources)).execute([&] {
    ReadScene read(load_settings, load_edits(settings, progress),
                   {.build = build, .edits = true, .poses = poses, .nodes = true}, progress);
    const SceneEdits edits = read.edits();
    animation = edits.animation;
    animations = read.description().animations;
    files.add(read.description().files);
    bounds = framed_bounds(read.description());
    open = std::move(read).build(progress);
    open->editable().set(edits);
  });
}

void Scene::State::pose(const FrameSettings& pose_settings, const std::stop_token& stop) {
  FrameSettings new_settings = settings;
  new_settings.animation = pose_settings.animation;
  new_settings.time = pose_settings.time;
  new_settings.frame = pose_settings.frame;
  new_settings.fps = pose_settings.fps;
  new_settings.shutter = pose_settings.shutter;
  new_settings.aovs = pose_settings.aovs;
  FrameSettings load_settings = new_settings;
  load_settings.variant.clear();  // the edits include the variant
  load_settings.light_groups = false;
  SceneEdits edits = open->editable().edits();
  edits.animation = {};
  LoadProgress progress({}, stop, limits);
  tbb::task_arena(arena_threads(resources)).execute([&] {
    ReadScene read = open->read(load_settings, edits, progress);
    const WorldBounds posed = framed_bounds(read.description());
    open->pose(std::move(read), progress);
    bounds = posed;
    settings = new_settings;
  });
}

void Scene::State::edit(std::string_view json, const Environment& environment) {
  SceneEdits edits = parse_edits(json, "the edits");
  if (environment.rgb) {
    if (edits.environment.image) {
      throw emberline::UsageError(
          "environment: give either a picture or a file in the edits, not both");
    }
    edits.environment.image = image_of(environment);
  }
  if (edits.animation != AnimationEdit() && edits.animation != animation) {
    throw emberline::InputError(edits.animation.place,
                                "edits cannot pose a scene; use the settings or pose()");
  }
  open->editable().set(edits);
  edited = edits == SceneEdits() ? "" : fingerprint_of(json, edits);
}

Scene::Scene(std::unique_ptr<State> state) : state_(std::move(state)) {}
Scene::Scene(const std::string& path, const Settings& settings, const Resources& resources,
             const std::stop_token& stop)
    : Scene(translate_errors(
          [&] { return std::make_unique<State>(path, settings, resources, stop, false); })) {}
Scene Scene::animated(const std::string& path, const Settings& settings, const Resources& resources,
                      const std::stop_token& stop) {
  return Scene(translate_errors(
      [&] { return std::make_unique<State>(path, settings, resources, stop, true); }));
}
Scene::Scene(Scene&& other) noexcept = default;
Scene& Scene::operator=(Scene&& other) noexcept = default;
Scene::~Scene() = default;

void Scene::pose(const Settings& settings, const std::stop_token& stop) {
  translate_errors([&] {
    if (!state_->open->can_pose()) {
      throw emberline::UsageError(
          "pose: the scene has no animations, or it was not loaded as an animated scene");
    }
    state_->pose(Access::impl(settings), stop);
  });
}

void Scene::edit(std::string_view json) { edit(json, {}); }

void Scene::edit(std::string_view json, const Environment& environment) {
  translate_errors([&] { state_->edit(json, environment); });
}

std::vector<std::string> Scene::lights() const {
  return names_of(state_->open->editable().original().lights);
}
std::vector<std::string> Scene::materials() const {
  return names_of(state_->open->editable().original().materials);
}
std::vector<std::string> Scene::cameras() const {
  return names_of(state_->open->editable().original().cameras);
}
std::vector<std::string> Scene::light_sources() const {
  const SceneDescription& scene = state_->open->editable().original();
  std::vector<std::string> names = names_of(scene.lights);
  for (const MaterialDescription& material : scene.materials) {
    if (emits(material)) names.push_back(material.name);
  }
  if (scene.environment) names.emplace_back("environment");
  return names;
}
std::vector<Scene::Node> Scene::nodes() const {
  std::vector<Node> nodes;
  for (const NodeDescription& node : state_->open->editable().original().nodes) {
    nodes.push_back(
        {node.name, node.parent, node.has_mesh, node.has_camera, node.has_light, node.in_scene});
  }
  return nodes;
}
std::vector<Scene::Animation> Scene::animations() const {
  std::vector<Animation> animations;
  for (const AnimationDescription& animation : state_->animations) {
    animations.push_back({animation.name, animation.duration});
  }
  return animations;
}
std::string Scene::editable() const {
  return format_edits(edits_template(state_->open->editable().original()));
}
std::vector<std::string> Scene::approximated() const {
  return state_->open->coverage().approximated;
}
std::vector<std::string> Scene::ignored() const { return state_->open->coverage().ignored; }

}  // namespace emberline::api
