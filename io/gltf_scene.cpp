#include "io/gltf_scene.h"

#include <algorithm>
#include <exception>

#include "io/gltf_accessor.h"
#include "io/gltf_extensions.h"
#include "io/gltf_mesh.h"
#include "io/gltf_node_objects.h"
#include "io/gltf_transform.h"
#include "io/gltf_variants.h"
#include "io/tiny_gltf_renamed.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

using nlohmann::json;

// A mesh in one pose; all its primitives.
struct MeshUse {
  size_t mesh = 0;
  MeshPose pose;
  std::vector<int> loaded;  // indices into SceneDescription::meshes
};

// A use placed in the world.
struct Placement {
  size_t use = 0;
  size_t node = 0;
  Mat44d to_world;
};

class SceneGraphReader {
 public:
  SceneGraphReader(const GltfDocument& document, const tinygltf::Model& model,
                   SceneDescription& scene)
      : document_(document),
        model_(model),
        scene_(scene),
        world_(world_transforms(document, model)),
        plain_use_(model.nodes.empty() ? 0 : document.array("meshes").size(), -1) {}

  void read() {
    for (const size_t node : nodes_in_scene()) read_node(node);
    load_meshes();
    place_meshes();
    report();
  }

 private:
  std::vector<size_t> nodes_in_scene() const;
  void read_node(size_t node);
  void read_mesh_node(size_t node);
  MeshPose rest_pose(size_t node, size_t mesh, Mat44d* to_world);
  size_t find_use(size_t mesh, MeshPose pose);
  void check_budget() const;
  void load_meshes();
  LoadedMesh load_primitive_of(const MeshUse& use, size_t primitive) const;
  void place_meshes();
  void report();

  const GltfDocument& document_;
  const tinygltf::Model& model_;
  SceneDescription& scene_;
  const std::vector<Mat44d> world_;
  std::vector<MeshUse> uses_;
  std::vector<int> plain_use_;  // per mesh: its use without a skin or weights of a node, or -1
  std::vector<Placement> placements_;
};

// Depth first, in file order, without recursion: hierarchies may be any number of levels deep.
std::vector<size_t> SceneGraphReader::nodes_in_scene() const {
  std::vector<int> roots;
  if (!model_.scenes.empty()) {
    const int chosen = std::max(model_.defaultScene, 0);
    roots = model_.scenes[size_t(chosen)].nodes;
  } else {
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      if (document_.parents[i] < 0) roots.push_back(int(i));
    }
  }
  std::vector<size_t> nodes;
  std::vector<char> seen(model_.nodes.size(), 0);
  std::vector<int> stack(roots.rbegin(), roots.rend());
  while (!stack.empty()) {
    const size_t node = size_t(stack.back());
    stack.pop_back();
    if (seen[node]) continue;  // a scene that lists a node and its descendant
    seen[node] = 1;
    nodes.push_back(node);
    const std::vector<int>& children = model_.nodes[node].children;
    stack.insert(stack.end(), children.rbegin(), children.rend());
  }
  return nodes;
}

void SceneGraphReader::read_node(size_t node) {
  const tinygltf::Node& source = model_.nodes[node];
  const json& object = document_.json.at("nodes")[node];
  if (source.mesh >= 0) read_mesh_node(node);
  if (source.camera >= 0) read_camera(document_, model_, node, world_[node], scene_);
  if (find_extension(object, "KHR_lights_punctual")) {
    read_punctual_light(document_, model_, node, world_[node], scene_);
  }
}

MeshPose SceneGraphReader::rest_pose(size_t node, size_t mesh, Mat44d* to_world) {
  const tinygltf::Node& source = model_.nodes[node];
  const json& mesh_object = document_.json.at("meshes")[mesh];
  MeshPose pose;
  pose.weights = source.weights;
  if (pose.weights.empty()) pose.weights = mesh_object.value("weights", std::vector<double>());
  const bool morphs = std::any_of(
      mesh_object.at("primitives").begin(), mesh_object.at("primitives").end(),
      [](const json& primitive) { return !primitive.value("targets", json::array()).empty(); });
  if (morphs) {
    report_approximated(document_.file, "morph targets (evaluated at the file's rest pose)",
                        scene_.coverage);
  } else {
    pose.weights.clear();
  }
  if (source.skin < 0) return pose;

  report_approximated(document_.file, "skin (evaluated at the file's rest pose)", scene_.coverage);
  const tinygltf::Skin& skin = model_.skins[size_t(source.skin)];
  std::vector<float> inverse_bind;
  if (skin.inverseBindMatrices >= 0) {
    inverse_bind = read_floats(
        document_, skin.inverseBindMatrices, 16,
        document_.place("/skins/" + std::to_string(source.skin) + "/inverseBindMatrices"));
  }
  // Joints place the vertices in the world, the node's own transform does not count (section
  // 3.7.3.3). The first joint's position is kept apart in double, for scenes far from the origin.
  const Mat44d& first = world_[size_t(skin.joints[0])];
  const Vec3d origin(first[3][0], first[3][1], first[3][2]);
  *to_world = Mat44d();
  to_world->setTranslation(origin);
  Mat44d from_origin;
  from_origin.setTranslation(-origin);
  for (size_t j = 0; j < skin.joints.size(); ++j) {
    Mat44d bind;
    for (int e = 0; e < 16 && !inverse_bind.empty(); ++e) {
      bind[e / 4][e % 4] = inverse_bind[j * 16 + size_t(e)];
    }
    pose.joints.push_back(bind * world_[size_t(skin.joints[j])] * from_origin);
    check_transform(pose.joints.back(), document_.place("/skins/" + std::to_string(source.skin) +
                                                        "/joints/" + std::to_string(j)));
  }
  return pose;
}

size_t SceneGraphReader::find_use(size_t mesh, MeshPose pose) {
  const json& mesh_object = document_.json.at("meshes")[mesh];
  const bool plain =
      pose.joints.empty() &&
      (pose.weights.empty() || pose.weights == mesh_object.value("weights", std::vector<double>()));
  if (plain && plain_use_[mesh] >= 0) return size_t(plain_use_[mesh]);
  uses_.push_back({mesh, std::move(pose), {}});
  if (plain) plain_use_[mesh] = int(uses_.size() - 1);
  return uses_.size() - 1;
}

void SceneGraphReader::read_mesh_node(size_t node) {
  const size_t mesh = size_t(model_.nodes[node].mesh);
  Mat44d to_world = world_[node];
  const size_t use = find_use(mesh, rest_pose(node, mesh, &to_world));
  const json& object = document_.json.at("nodes")[node];
  if (const json* instancing = find_extension(object, "EXT_mesh_gpu_instancing")) {
    for (const Mat44d& local : read_instance_transforms(document_, *instancing, node)) {
      placements_.push_back({use, node, local * to_world});
    }
  } else {
    placements_.push_back({use, node, to_world});
  }
  // A few nodes and a few primitives can multiply to more than memory holds.
  const size_t most = (size_t(1) << 20) + size_t(document_.total_bytes);
  if (placements_.size() > most) {
    throw InputError(document_.place("/nodes/" + std::to_string(node)),
                     "more than " + std::to_string(most) +
                         " instances, more than the size of the file bears out");
  }
}

// Primitives may share accessors, so that a small file could ask for any number of triangles; and
// skinned nodes a primitive, whose variants count as an index each. The allowance is chosen by us:
// sharing sixty-fourfold is unheard of.
void SceneGraphReader::check_budget() const {
  uint64_t backed = document_.total_bytes;
  for (const GltfAccessor& accessor : document_.accessors) {
    if (accessor.view >= 0) backed += accessor.count;
  }
  uint64_t indices = 0;
  for (const MeshUse& use : uses_) {
    for (const json& primitive : document_.json.at("meshes")[use.mesh].at("primitives")) {
      indices += variant_material_count(primitive);
      // A Draco stream vouches for its own count.
      if (find_extension(primitive, "KHR_draco_mesh_compression")) continue;
      const json* member = find_member(primitive, "indices");
      if (!member) member = find_member(primitive.at("attributes"), "POSITION");
      if (member) indices += document_.accessors[member->get<size_t>()].count;
    }
  }
  if (indices > (uint64_t(1) << 22) + backed * 64) {
    throw InputError(document_.file, "the meshes add up to " + std::to_string(indices) +
                                         " indices, more than the size of the file bears out");
  }
}

LoadedMesh SceneGraphReader::load_primitive_of(const MeshUse& use, size_t index) const {
  static const MaterialDescription default_material;
  const json& primitive = document_.json.at("meshes")[use.mesh].at("primitives")[index];
  std::vector<VariantMaterial> others;
  if (scene_.variants_read) {
    others = read_variant_materials(
        document_, primitive,
        "/meshes/" + std::to_string(use.mesh) + "/primitives/" + std::to_string(index));
  }
  const int own = primitive.value("material", -1);
  std::vector<const MaterialDescription*> materials = {own >= 0 ? &scene_.materials[size_t(own)]
                                                                : &default_material};
  for (const VariantMaterial& other : others) {
    materials.push_back(&scene_.materials[size_t(other.material)]);
  }
  LoadedMesh loaded = load_primitive(document_, use.mesh, index, use.pose, materials);
  loaded.mesh.variant_materials = std::move(others);
  return loaded;
}

void SceneGraphReader::load_meshes() {
  check_budget();
  struct Task {
    size_t use, primitive;
    LoadedMesh result;
    std::exception_ptr error;
  };
  std::vector<Task> tasks;
  for (size_t u = 0; u < uses_.size(); ++u) {
    const size_t count = document_.json.at("meshes")[uses_[u].mesh].at("primitives").size();
    for (size_t p = 0; p < count; ++p) tasks.push_back({u, p, {}, nullptr});
  }
  document_.progress->begin(LoadStage::kMeshes, tasks.size());
  parallel_each(tasks.size(), [&](size_t i) {
    document_.progress->check();
    Task& task = tasks[i];
    try {
      task.result = load_primitive_of(uses_[task.use], task.primitive);
    } catch (...) {
      task.error = std::current_exception();
    }
    document_.progress->advance();
  });
  for (Task& task : tasks) {
    // The first in file order, so that the message does not depend on timing.
    if (task.error) std::rethrow_exception(task.error);
    for (const std::string& what : task.result.ignored) {
      report_ignored(document_.file, what, scene_.coverage);
    }
    for (const std::string& what : task.result.approximated) {
      report_approximated(document_.file, what, scene_.coverage);
    }
    scene_.repairs.degenerate_triangles += task.result.repairs.degenerate_triangles;
    scene_.repairs.non_finite_triangles += task.result.repairs.non_finite_triangles;
    if (task.result.mesh.triangles.empty()) continue;
    uses_[task.use].loaded.push_back(int(scene_.meshes.size()));
    scene_.meshes.push_back(std::move(task.result.mesh));
  }
}

void SceneGraphReader::place_meshes() {
  uint64_t count = 0;
  for (const Placement& placement : placements_) count += uses_[placement.use].loaded.size();
  const uint64_t most = (uint64_t(1) << 20) + document_.total_bytes;
  if (count > most) {
    throw InputError(document_.file, std::to_string(count) +
                                         " instances, more than the size of the file bears out");
  }
  scene_.instances.reserve(count);
  for (const Placement& placement : placements_) {
    const std::string place = document_.place("/nodes/" + std::to_string(placement.node));
    check_transform(placement.to_world, place);
    if (is_singular(placement.to_world)) {
      ++scene_.repairs.singular_instances;
      continue;
    }
    const std::string name = node_name(model_, placement.node);
    for (const int mesh : uses_[placement.use].loaded) {
      scene_.instances.push_back({name, mesh, placement.to_world});
    }
  }
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
  if (scene_.instances.empty()) {
    throw InputError(document_.file, "no geometry to render" +
                                         (dropped.empty() ? "" : " (left out: " + dropped + ")"));
  }
  if (!dropped.empty()) log_warning(document_.file + ": left out: " + dropped);
}

}  // namespace

void load_scene_graph(const GltfDocument& document, const tinygltf::Model& model,
                      SceneDescription& scene) {
  SceneGraphReader(document, model, scene).read();
}

}  // namespace emberline
