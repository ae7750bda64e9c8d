#include "io/gltf/animation/poses.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "io/gltf/document/accessor.h"
#include "io/gltf/document/tiny_gltf_renamed.h"
#include "io/gltf/geometry/transform.h"

namespace emberline {

using nlohmann::json;

GltfPoses::GltfPoses(const GltfDocument& document, const GltfShutter& shutter)
    : document_(document),
      shutter_(shutter),
      memory_(document.progress->budget(), MemoryPart::kGeometry) {
  for (const json& mesh : document.array("meshes")) defaults_.push_back(morph_defaults(mesh));
}

GltfPoses::MorphDefaults GltfPoses::morph_defaults(const json& mesh) {
  if (mesh.is_null()) return {};
  const json& primitives = mesh.at("primitives");
  const bool morphs = std::any_of(primitives.begin(), primitives.end(), [](const json& primitive) {
    const json* targets = find_member(primitive, "targets");
    return targets && !targets->empty();
  });
  if (!morphs) return {};
  return {true, mesh.value("weights", std::vector<double>())};
}

const SkinPose& GltfPoses::skin(int index) {
  const auto [entry, is_new] = skins_.try_emplace(index);
  SkinPose& pose = entry->second;
  if (!is_new) return pose;
  const tinygltf::Skin& source = document_.model->skins[size_t(index)];
  const std::string pointer = "/skins/" + std::to_string(index);
  const std::string place = document_.place(pointer);
  document_.faults->require(pointer);
  for (const int joint : source.joints)
    document_.faults->require("/nodes/" + std::to_string(joint));
  std::vector<float> inverse_bind;
  if (source.inverseBindMatrices >= 0) {
    std::vector<uint32_t> joint_elements(source.joints.size());
    std::iota(joint_elements.begin(), joint_elements.end(), 0u);
    inverse_bind = read_floats(document_, source.inverseBindMatrices, 16,
                               place + "/inverseBindMatrices", &joint_elements);
  }
  // Joints move vertices to world space. Therefore the transform of the mesh's node is ignored
  // (section 3.7.3.3).
  const Mat44d& first = shutter_.world()[size_t(source.joints[0])];
  pose.origin = row(first, 3);
  const Mat44d from_origin = Mat44d().setTranslation(-pose.origin);
  const bool moves = std::ranges::any_of(
      source.joints, [this](int joint) { return shutter_.moves(size_t(joint)); });
  const size_t steps = moves ? shutter_.steps() : 1;
  memory_.add(bytes_of(source.joints.size(), steps * sizeof(Mat44d)), place);
  for (size_t step = 0; step < steps; ++step) {
    std::vector<Mat44d>& joints = pose.joints.emplace_back();
    joints.reserve(source.joints.size());
    for (size_t j = 0; j < source.joints.size(); ++j) {
      Mat44d bind;
      for (int e = 0; e < 16 && !inverse_bind.empty(); ++e) {
        bind[e / 4][e % 4] = inverse_bind[j * 16 + size_t(e)];
      }
      const auto joint = size_t(source.joints[j]);
      const Mat44d& world =
          step > 0 && shutter_.moves(joint) ? shutter_.world(joint, step) : shutter_.world()[joint];
      joints.push_back(bind * world * from_origin);
      check_transform(joints.back(), place + "/joints/" + std::to_string(j));
    }
  }
  return pose;
}

// Returns the weights that the pose has for the node. If the pose has none, returns the node's own
// weights. If the node has none either, returns the mesh's.
const std::vector<double>& GltfPoses::weights_of(size_t node, size_t step) const {
  const GltfPose& pose = shutter_.pose(step);
  const auto posed = pose.find(node);
  if (posed != pose.end() && !posed->second.weights.empty()) return posed->second.weights;
  const tinygltf::Node& source = document_.model->nodes[node];
  return source.weights.empty() ? defaults_[size_t(source.mesh)].weights : source.weights;
}

std::vector<MeshPose> GltfPoses::mesh_poses(size_t node) {
  const tinygltf::Node& source = document_.model->nodes[node];
  const bool morphs = defaults_[size_t(source.mesh)].morphs;
  static const std::vector<std::vector<Mat44d>> no_skin;
  const auto& joints = source.skin >= 0 ? skin(source.skin).joints : no_skin;
  const auto pose = [&](size_t step) {
    MeshPose p;
    if (morphs) p.weights = weights_of(node, step);
    if (!joints.empty()) p.joints = joints[std::min(step, joints.size() - 1)];
    return p;
  };
  bool moves = joints.size() > 1;
  for (size_t step = 1; step < shutter_.steps() && morphs; ++step) {
    moves = moves || weights_of(node, step) != weights_of(node, 0);
  }
  if (!moves) return {pose(0)};
  std::vector<MeshPose> all;
  for (size_t step = 0; step < shutter_.steps(); ++step) all.push_back(pose(step));
  return reduce_poses(std::move(all), shutter_.radius(size_t(source.mesh)));
}

bool GltfPoses::has_own_weights(size_t node) const {
  const MorphDefaults& defaults = defaults_[size_t(document_.model->nodes[node].mesh)];
  if (!defaults.morphs) return false;
  const auto posed = shutter_.pose().find(node);
  const bool is_animated = posed != shutter_.pose().end() && !posed->second.weights.empty();
  return is_animated || weights_of(node, 0) != defaults.weights;
}

}  // namespace emberline
