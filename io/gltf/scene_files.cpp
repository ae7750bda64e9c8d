#include "io/gltf/scene_files.h"

#include <algorithm>

#include "io/gltf/document/document.h"
#include "io/gltf/document/uri.h"
#include "renderer/core/errors.h"

namespace emberline {

namespace fs = std::filesystem;

std::vector<fs::path> scene_files(const std::string& path, const std::string& resource_root,
                                  LoadProgress& progress) {
  const GltfDocument document = open_gltf_document(path, resource_root, progress);
  const fs::path scene = fs::absolute(path).lexically_normal();
  std::vector<fs::path> files = {scene};
  for (const std::string& uri : document.external_uris()) {
    try {
      document.open_resource(uri, path);  // checks that the file exists inside the root
      const fs::path name = resolve_uri(uri, document.resources, path).name;
      const fs::path file = (scene.parent_path() / name).lexically_normal();
      if (std::ranges::find(files, file) == files.end()) files.push_back(file);
    } catch (const InputError&) {
      progress.check();  // only checks for cancellation; loading the scene will report the error
    }
  }
  return files;
}

}  // namespace emberline
