// The name of tinygltf's namespace in this program; see gltf/document/tiny_gltf_renamed.h.
#pragma once

namespace emberline_tinygltf {
class Model;
}

namespace emberline {
namespace tinygltf = ::emberline_tinygltf;
}
