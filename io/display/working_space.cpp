#include "io/display/working_space.h"

#include <OpenColorIO/OpenColorIO.h>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

namespace ocio = OCIO_NAMESPACE;

constexpr NamedValue<WorkingSpace> kWorkingSpaces[] = {
    {"rec709", "linear Rec. 709, the primaries of glTF", WorkingSpace::kRec709},
    {"acescg", "ACEScg (AP1); OpenColorIO converts the scene and the output",
     WorkingSpace::kAcesCg},
};

ToWorkingSpace acescg_matrix(ocio::TransformDirection direction) {
  try {
    const ocio::BuiltinTransformRcPtr transform = ocio::BuiltinTransform::Create();
    transform->setStyle("UTILITY - ACES-AP1_to_LINEAR-REC709_BFD");
    transform->setDirection(direction);
    const auto processor = ocio::Config::CreateRaw()->getProcessor(transform);
    const auto cpu = processor->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);
    float primaries[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    ocio::PackedImageDesc image(primaries, 3, 1, 3);
    cpu->apply(image);
    const float* p = primaries;
    return std::make_shared<const ColourMatrix>(
        ColourMatrix{{p[0], p[3], p[6]}, {p[1], p[4], p[7]}, {p[2], p[5], p[8]}});
  } catch (const ocio::Exception& error) {
    throw RenderError(std::string("OpenColorIO cannot convert to ACEScg: ") + error.what());
  }
}

}  // namespace

std::span<const NamedValue<WorkingSpace>> working_space_table() { return kWorkingSpaces; }

ToWorkingSpace to_working_space(WorkingSpace space) {
  if (space == WorkingSpace::kRec709) return nullptr;
  static const ToWorkingSpace kMatrix = acescg_matrix(ocio::TRANSFORM_DIR_INVERSE);
  return kMatrix;
}

ToWorkingSpace from_working_space(WorkingSpace space) {
  if (space == WorkingSpace::kRec709) return nullptr;
  static const ToWorkingSpace kMatrix = acescg_matrix(ocio::TRANSFORM_DIR_FORWARD);
  return kMatrix;
}

}  // namespace emberline
