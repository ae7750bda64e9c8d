#include "io/gltf/geometry/scene.h"

#include <algorithm>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "io/gltf/animation/poses.h"
#include "io/gltf/animation/shutter.h"
#include "io/gltf/animation/visibility.h"
#include "io/gltf/document/extensions.h"
#include "io/gltf/document/tiny_gltf_renamed.h"
#include "io/gltf/geometry/mesh_uses.h"
#include "io/gltf/geometry/node_objects.h"
#include "io/gltf/geometry/transform.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"
#include "renderer/description/framing.h"

namespace emberline {
namespace {

using nlohmann::json;

// A MeshUse with its transform. There is one for each instance of a node's mesh.
struct Placement {
  size_t use = 0;
  size_t node = 0;
  Mat44d to_world;
  std::vector<Mat44d> motion;  // per step of GltfShutter; empty if the mesh does not move
};

// Returns the nodes depth-first in file order. Not recursive, since hierarchies may be arbitrarily
// deep.
std::vector<size_t> nodes_in_scene(const GltfDocument& document) {
  std::vector<int> roots;
  if (!document.model->scenes.empty()) {
    const int chosen = std::max(document.model->defaultScene, 0);
    roots = document.model->scenes[size_t(chosen)].nodes;
  } else {
    for (size_t i = 0; i < document.model->nodes.size(); ++i) {
      if (document.parents[i] < 0) roots.push_back(int(i));
    }
  }
  std::vector<size_t> nodes;
  std::vector<char> seen(document.model->nodes.size(), 0);
  std::vector<int> stack(roots.rbegin(), roots.rend());
  while (!stack.empty()) {
    const size_t node = size_t(stack.back());
    stack.pop_back();
    if (seen[node]) continue;  // the scene may list both a node and its descendant
    seen[node] = 1;
    nodes.push_back(node);
    const std::vector<int>& children = document.model->nodes[node].children;
    stack.insert(stack.end(), children.rbegin(), children.rend());
  }
  return nodes;
}

class SceneGraphReader {
 public:
  SceneGraphReader(const GltfDocument& document, const GltfAnimation& animation,
                   const GltfAnimatedValues& changes, std::span<const uint64_t> held,
                   GltfCache& cache, SceneDescription& scene)
      : document_(document),
        changes_(changes),
        scene_(scene),
        animation_(animation),
        cache_(cache),
        at_rest_(animation.at_rest),
        shutter_(document, animation),
        world_(shutter_.world()),
        visibility_(document, animation),
        poses_(document, shutter_),
        meshes_(document, shutter_.is_instant(), held, cache, scene),
        placements_memory_(document.progress->budget(), MemoryPart::kGeometry),
        instances_memory_(document.progress->budget(), MemoryPart::kGeometry) {}

  void read() {
    find_moving_meshes();
    for (const size_t node : nodes_in_scene(document_)) read_node(node);
    meshes_.load(uses_, at_rest_);
    place_meshes();
    if (!at_rest_) scene_.rest_bounds = rest_bounds();
    report();
  }

 private:
  void read_node(size_t node);
  void read_mesh_node(size_t node);
  std::optional<Mat44d> aimed(size_t node, size_t step) const;
  void read_camera_node(size_t node);
  void read_light_node(size_t node);
  void add_motion(size_t node, std::vector<Mat44d>& motion) const;
  void find_moving_meshes();
  // Returns the transforms of EXT_mesh_gpu_instancing. They are valid until the next call.
  const std::vector<Mat44d>& instance_transforms(const json& instancing, size_t node);
  size_t find_or_add_use(size_t node, bool flat);
  bool is_flat(const Placement& placement) const;
  // Invertible transforms of a placement. `next_frame` is the transform at the time
  // GltfAnimation::next_frame.
  struct Transforms {
    Mat44d to_world;
    std::vector<Mat44d> motion;
    std::optional<Mat44d> next_frame;
  };
  std::optional<Transforms> invertible_transforms(const Placement& placement);
  bool undeformed(size_t node) const;
  void place_meshes();
  WorldBounds rest_bounds() const;
  [[noreturn]] void throw_empty(const std::string& dropped) const;
  std::optional<std::string> find_broken_geometry() const;
  void check_empty(const std::string& dropped) const;
  void report();

  const GltfDocument& document_;
  const GltfAnimatedValues& changes_;
  SceneDescription& scene_;
  const GltfAnimation& animation_;
  GltfCache& cache_;
  std::vector<char> may_move_;          // per node
  std::vector<char> mesh_may_move_;     // per mesh: whether any node that uses it may move
  bool mesh_weights_animated_ = false;  // whether animation pointers change any mesh's weights
  const bool at_rest_;
  const GltfShutter shutter_;
  const std::vector<Mat44d>& world_;  // per node, at shutter opening
  const GltfVisibility visibility_;
  std::vector<size_t> hidden_nodes_;  // only nodes with meshes
  uint64_t collapsed_instances_ = 0;  // instances whose scale collapses them to a line or a point
  GltfPoses poses_;
  GltfMeshUses meshes_;
  std::vector<MeshUse> uses_;
  // Mesh uses that nodes may share, by mesh, by skin, and by whether the node flattens the mesh.
  std::map<std::tuple<int, int, bool>, size_t> shared_uses_;
  std::deque<Placement> placements_;  // a deque, so that growing does not copy
  MemoryReservation placements_memory_;
  std::vector<Mat44d> instances_;  // result of instance_transforms() in a scene at rest
  MemoryReservation instances_memory_;
};

void SceneGraphReader::read_node(size_t node) {
  const tinygltf::Node& source = document_.model->nodes[node];
  const json& object = document_.json->at("nodes")[node];
  document_.faults->require("/nodes/" + std::to_string(node));
  if (source.mesh >= 0) {
    if (visibility_.is_ever_visible(node)) {
      read_mesh_node(node);
    } else {
      hidden_nodes_.push_back(node);
    }
  }
  read_camera_node(node);
  constexpr const char* kPunctual = "KHR_lights_punctual";
  if (!visibility_.is_ever_visible(node) || !find_extension(object, kPunctual)) return;
  try {
    read_light_node(node);
  } catch (const InputError& error) {
    GltfFaults::rethrow_limit_error(error);
    if (document_.requires_extension(kPunctual)) throw;
    document_.faults->note_defaulted("/nodes/" + std::to_string(node) + "/extensions/" + kPunctual,
                                     error);
  }
}

void SceneGraphReader::read_camera_node(size_t node) {
  CameraDescription* const camera =
      read_camera(document_, node, shutter_.pose(), world_[node], scene_);
  if (!camera) return;
  add_motion(node, camera->motion);
  if (shutter_.is_instant() && shutter_.moves(node)) {
    camera->next_frame = aimed(node, 1).value_or(camera->to_world);
  }
  changes_.apply(size_t(document_.model->nodes[node].camera), *camera);
}

void SceneGraphReader::read_light_node(size_t node) {
  PunctualLightDescription* const light =
      read_punctual_light(document_, node, shutter_.pose(), world_[node], scene_);
  if (!light) return;
  add_motion(node, light->motion);
  const json& object = document_.json->at("nodes")[node];
  const json& reference = *find_extension(object, "KHR_lights_punctual");
  changes_.apply(reference.at("light").get<size_t>(), *light);
  light->visibility = visibility_.times(node);
}

std::optional<Mat44d> SceneGraphReader::aimed(size_t node, size_t step) const {
  return aimed_transform(document_, node, shutter_.pose(step), shutter_.world(node, step));
}

void SceneGraphReader::add_motion(size_t node, std::vector<Mat44d>& motion) const {
  if (!shutter_.moves(node) || shutter_.is_instant()) return;
  // If the transform of a step defines no direction, the direction of the previous step is kept.
  Mat44d last = aimed(node, 0).value_or(shutter_.world(node, 0));
  for (size_t step = 1; step < shutter_.steps(); ++step) {
    const Mat44d& world = shutter_.world(node, step);
    last = aimed(node, step).value_or(last);
    for (int c = 0; c < 3; ++c) last[3][c] = world[3][c];
    motion.push_back(last);
  }
}

void SceneGraphReader::find_moving_meshes() {
  mesh_may_move_.assign(document_.array("meshes").size(), 0);
  if (at_rest_) return;
  may_move_ = nodes_that_may_move(document_, animation_);
  for (size_t node = 0; node < may_move_.size(); ++node) {
    const tinygltf::Node& source = document_.model->nodes[node];
    if (may_move_[node] && source.mesh >= 0 && source.skin < 0) {
      mesh_may_move_[size_t(source.mesh)] = 1;
    }
  }
  for (const PointerTrack& track : animation_.pointers) {
    if (track.pointer.starts_with("/meshes/")) mesh_weights_animated_ = true;
  }
}

// Whether no animation deforms the node's mesh. Returns false for a scene at rest: it is posed only
// once, so its meshes need no cache.
bool SceneGraphReader::undeformed(size_t node) const {
  const tinygltf::Node& source = document_.model->nodes[node];
  if (at_rest_) return false;
  if (poses_.morphs(size_t(source.mesh)) &&
      (mesh_weights_animated_ || animation_.weights.contains(node))) {
    return false;
  }
  return source.skin < 0 ||
         std::ranges::none_of(document_.model->skins[size_t(source.skin)].joints,
                              [this](int joint) { return may_move_[size_t(joint)]; });
}

size_t SceneGraphReader::find_or_add_use(size_t node, bool flat) {
  const tinygltf::Node& source = document_.model->nodes[node];
  document_.faults->require("/meshes/" + std::to_string(source.mesh));
  const auto report_rest = [&](bool is_there, const std::string& what) {
    if (!is_there || !at_rest_) return;
    report_approximated(document_.file, what + " (shown in the file's rest pose)", scene_.coverage);
  };
  report_rest(poses_.morphs(size_t(source.mesh)), "morph targets");
  report_rest(source.skin >= 0, "skin");
  // Joints determine where a skinned mesh is, so nodes with the same mesh and skin share a MeshUse.
  const bool own_weights = poses_.has_own_weights(node);
  const std::tuple key(source.mesh, source.skin, flat);
  if (!own_weights && shared_uses_.contains(key)) return shared_uses_.at(key);
  MeshUse& use = uses_.emplace_back();
  use.mesh = size_t(source.mesh);
  use.poses = poses_.mesh_poses(node);
  use.skin = source.skin;
  use.node = own_weights ? int(node) : -1;
  use.undeformed = undeformed(node);
  use.may_move = mesh_may_move_[use.mesh];
  use.flat = flat;
  if (!own_weights) shared_uses_.emplace(key, uses_.size() - 1);
  return uses_.size() - 1;
}

const std::vector<Mat44d>& SceneGraphReader::instance_transforms(const json& instancing,
                                                                 size_t node) {
  const auto cached = cache_.instancing.find(node);
  if (cached != cache_.instancing.end()) return cached->second;
  if (at_rest_) instances_memory_.release();
  MemoryReservation& memory = at_rest_ ? instances_memory_ : cache_.memory;
  std::vector<Mat44d> read = read_instance_transforms(document_, instancing, node, memory);
  if (at_rest_) return instances_ = std::move(read);
  return cache_.instancing[node] = std::move(read);
}

void SceneGraphReader::read_mesh_node(size_t node) {
  document_.faults->require("/meshes/" + std::to_string(document_.model->nodes[node].mesh));
  Mat44d to_world = world_[node];
  if (const int skin = document_.model->nodes[node].skin; skin >= 0) {
    to_world = Mat44d().setTranslation(poses_.skin(skin).origin);
  }
  const json& object = document_.json->at("nodes")[node];
  const std::string place = document_.place("/nodes/" + std::to_string(node));
  const json* instancing = find_extension(object, "EXT_mesh_gpu_instancing");
  static const std::vector<Mat44d> one = {Mat44d()};
  const std::vector<Mat44d>& instances = instancing ? instance_transforms(*instancing, node) : one;
  // A small file can ask for more placements than fit into memory.
  const size_t most = (size_t(1) << 20) + size_t(document_.total_bytes);
  if (placements_.size() + instances.size() > most) {
    throw InputError(place, "more than {} instances, too many for a file of this size", most);
  }
  const bool moves = shutter_.moves(node) && document_.model->nodes[node].skin < 0;
  const size_t matrices = moves ? shutter_.steps() : 0;
  placements_memory_.add(bytes_of(instances.size(), sizeof(Placement) + matrices * sizeof(Mat44d)),
                         place);
  std::optional<size_t> uses[2];  // [0]: not flattened, [1]: flattened
  const auto use_of = [&](bool flat) {
    if (!uses[flat]) uses[flat] = find_or_add_use(node, flat);
    return *uses[flat];
  };
  if (instances.empty()) use_of(false);
  for (const Mat44d& instance : instances) {
    Placement& placement = placements_.emplace_back(Placement{0, node, instance * to_world, {}});
    for (size_t step = 0; step < matrices; ++step) {
      placement.motion.push_back(instance * shutter_.world(node, step));
      check_transform(placement.motion.back(), place);
    }
    placement.use = use_of(is_flat(placement));
    ++uses_[placement.use].placements;
  }
}

// Whether the placement is flat throughout the shutter interval.
bool SceneGraphReader::is_flat(const Placement& placement) const {
  if (shutter_.is_instant() || placement.motion.empty()) return is_singular(placement.to_world);
  return std::ranges::all_of(placement.motion, is_singular);
}

// Returns nothing if the placement is a line or a point throughout the shutter interval.
std::optional<SceneGraphReader::Transforms> SceneGraphReader::invertible_transforms(
    const Placement& placement) {
  const std::vector<Mat44d>& motion = placement.motion;
  const bool moves = !motion.empty() && !shutter_.is_instant();
  Transforms placed{placement.to_world, {}, {}};
  const bool is_invertible =
      moves ? std::ranges::none_of(motion, is_singular) : !is_singular(placed.to_world);
  MeshUse& use = uses_[placement.use];
  if (!is_invertible && !use.center) use.center = meshes_.center(use);
  if (moves) {
    placed.motion = make_invertible(motion, use.center.value_or(Vec3d(0.0)));
    if (placed.motion.empty()) return {};
    placed.to_world = placed.motion[0];
    return placed;
  }
  const bool changes_position = !motion.empty() && motion[1] != placement.to_world;
  if (changes_position) placed.next_frame = motion[1];
  if (is_invertible) return placed;
  const std::optional<Vec3d> axis = flattened_axis(placed.to_world);
  if (!axis) return {};
  placed.to_world = thickened(placed.to_world, *axis, kThickness, *use.center);
  if (changes_position) placed.next_frame = flattened(motion[1], *axis, *use.center);
  return placed;
}

void SceneGraphReader::place_meshes() {
  uint64_t count = 0, name_bytes = 0;
  for (const Placement& placement : placements_) {
    const size_t meshes = uses_[placement.use].loaded.size();
    count += meshes;
    name_bytes += bytes_of(meshes, node_name(document_, placement.node).capacity());
  }
  const uint64_t most = (uint64_t(1) << 20) + document_.total_bytes;
  if (count > most) {
    throw InputError(document_.file, "{} instances, too many for a file of this size", count);
  }
  const size_t bytes_each =
      sizeof(InstanceDescription) + (shutter_.is_instant() ? sizeof(NextFrameInstance) : 0);
  document_.reserve(MemoryPart::kGeometry, bytes_of(count, bytes_each) + name_bytes);
  scene_.instances.reserve(count);
  std::vector<double> radii(scene_.meshes.size(), -1.0);  // of moving meshes; -1: not computed
  for (const Placement& placement : placements_) {
    const std::string place = document_.place("/nodes/" + std::to_string(placement.node));
    check_transform(placement.to_world, place);
    const std::optional<Transforms> placed = invertible_transforms(placement);
    if (!placed) {
      ++scene_.repairs.singular_instances;
      if (!uses_[placement.use].loaded.empty()) ++collapsed_instances_;
      continue;
    }
    const std::string name = node_name(document_, placement.node);
    for (const int mesh : uses_[placement.use].loaded) {
      InstanceDescription instance{name, mesh, placed->to_world};
      instance.node = int(placement.node);
      if (!placed->motion.empty()) {
        double& radius = radii[size_t(mesh)];
        if (radius < 0.0) radius = meshes_.radius(size_t(mesh));
        instance.motion = reduce_transforms(placed->motion, radius);
        if (!instance.motion.empty()) instance.motion.erase(instance.motion.begin());
      } else if (placed->next_frame) {
        scene_.next_frame_instances.push_back(
            {uint32_t(scene_.instances.size()), *placed->next_frame});
      }
      instance.visibility = visibility_.times(placement.node);
      scene_.instances.push_back(std::move(instance));
    }
  }
}

// Returns the scene's bounds at rest, computed from the accessors' bounds and from the rest
// transforms of nodes and joints. Includes unskinned nodes that the animation hides at the current
// time. Skips meshes without accessor bounds. If no bounds are found, returns the bounds of the
// current pose.
WorldBounds SceneGraphReader::rest_bounds() const {
  const std::vector<Mat44d> at_rest = world_transforms(document_, {});
  WorldBounds bounds;
  for (const Placement& placement : placements_) {
    const WorldBounds& box = shutter_.bounds(uses_[placement.use].mesh);
    const size_t node = placement.node;
    if (const int skin = document_.model->nodes[node].skin; skin >= 0) {
      // If the bind pose is the rest pose, `bind * at_rest[joint]` is the identity.
      const auto joint = size_t(document_.model->skins[size_t(skin)].joints[0]);
      const SkinPose& pose = poses_.loaded_skin(skin);
      const Mat44d bind =
          pose.joints[0][0] * Mat44d().setTranslation(pose.origin) * world_[joint].inverse();
      bounds.add(box, bind * at_rest[joint]);
    } else {
      const Mat44d& world = world_[node];
      bounds.add(box, is_singular(world) ? at_rest[node]
                                         : placement.to_world * world.inverse() * at_rest[node]);
    }
  }
  for (const size_t node : hidden_nodes_) {
    if (!visibility_.may_be_visible(node) || document_.model->nodes[node].skin >= 0) continue;
    bounds.add(shutter_.bounds(size_t(document_.model->nodes[node].mesh)), at_rest[node]);
  }
  return bounds.isEmpty() ? world_bounds(scene_) : bounds;
}

// Throws the error for a file with nothing to render because its geometry is broken or has no
// surface.
void SceneGraphReader::throw_empty(const std::string& dropped) const {
  std::string found;
  for (const auto& [count, what] :
       {std::pair(meshes_.points(), " points"), std::pair(meshes_.lines(), " lines")}) {
    if (count > 0) found += (found.empty() ? "" : " and ") + readable_count(count) + what;
  }
  std::string text = found.empty() ? "no geometry to render"
                                   : "nothing to render: " + found + ", which have no surface";
  if (!dropped.empty()) text += " (left out: " + dropped + ")";
  if (const auto broken = find_broken_geometry()) text += "; the first error is: " + *broken;
  throw InputError(document_.file, text);
}

std::optional<std::string> SceneGraphReader::find_broken_geometry() const {
  return document_.faults->first_fault_below(
      {"/scenes/", "/nodes/", "/meshes/", "/skins/", "/accessors/", "/bufferViews/", "/buffers/"});
}

// Handles a scene without instances. Throws if all its geometry is broken or has no surface.
// Otherwise warns that only the environment is rendered.
void SceneGraphReader::check_empty(const std::string& dropped) const {
  const auto may_be_visible = [&](size_t node) { return visibility_.may_be_visible(node); };
  const bool visible_later = !at_rest_ && std::ranges::any_of(hidden_nodes_, may_be_visible);
  const LoadRepairs& repairs = scene_.repairs;
  if (!visible_later && collapsed_instances_ == 0 && !meshes_.collapsed()) {
    if (repairs.degenerate_triangles + repairs.non_finite_triangles > 0) throw_empty(dropped);
    if (meshes_.points() + meshes_.lines() > 0 && hidden_nodes_.empty()) throw_empty(dropped);
    if (find_broken_geometry()) throw_empty(dropped);
  }
  std::string why;
  if (!hidden_nodes_.empty()) why = std::to_string(hidden_nodes_.size()) + " invisible nodes";
  if (collapsed_instances_ > 0) {
    why += (why.empty() ? "" : ", ") + std::to_string(collapsed_instances_) +
           " objects scaled to zero";
  }
  log_warning(
      document_.file +
      (visible_later ? ": the animation hides all objects at this time" : ": nothing is visible") +
      (why.empty() ? "" : " (" + why + ")") + "; the picture shows only the environment");
}

void SceneGraphReader::report() {
  const LoadRepairs& repairs = scene_.repairs;
  std::string dropped;
  const auto note = [&](uint64_t count, const std::string& what) {
    if (count == 0) return;
    dropped += (dropped.empty() ? "" : ", ") + std::to_string(count) + " " + what;
  };
  note(repairs.degenerate_triangles, "triangles without area");
  note(repairs.non_finite_triangles, "triangles with a NaN or infinite vertex");
  note(repairs.singular_instances, "objects whose transform has no inverse");
  if (scene_.instances.empty()) check_empty(dropped);
  if (!dropped.empty()) log_warning(document_.file + ": left out: " + dropped);
  if (repairs.non_finite_attributes > 0) {
    log_warning(document_.file + ": " + std::to_string(repairs.non_finite_attributes) +
                " vertices have a NaN or infinite colour, normal, tangent or texture coordinate; 0 "
                "is used instead, or 1 for an infinite colour");
  }
}

}  // namespace

void load_scene_graph(const GltfDocument& document, const GltfAnimation& animation,
                      const GltfAnimatedValues& changes, std::span<const uint64_t> held,
                      GltfCache& cache, SceneDescription& scene) {
  SceneGraphReader(document, animation, changes, held, cache, scene).read();
}

std::vector<NodeDescription> read_nodes(const GltfDocument& document) {
  uint64_t bytes = bytes_of(document.model->nodes.size(), sizeof(NodeDescription));
  for (const tinygltf::Node& node : document.model->nodes) bytes += node.name.size();
  document.reserve(MemoryPart::kGeometry, bytes);
  std::vector<NodeDescription> nodes(document.model->nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    nodes[i].name = node_name(document, i);
    nodes[i].has_mesh = document.model->nodes[i].mesh >= 0;
    nodes[i].has_camera = document.model->nodes[i].camera >= 0;
    nodes[i].has_light =
        find_extension(document.json->at("nodes")[i], "KHR_lights_punctual") != nullptr;
    nodes[i].root = int(i);
  }
  for (const size_t node : nodes_in_scene(document)) nodes[node].in_scene = true;
  // Nodes on or below a cycle are not in `node_order`, so they get no parent.
  for (const int node : document.node_order) {
    const int parent = document.parents[size_t(node)];
    if (parent < 0) continue;
    nodes[size_t(node)].parent = parent;
    nodes[size_t(node)].root = nodes[size_t(parent)].root;
  }
  return nodes;
}

}  // namespace emberline
