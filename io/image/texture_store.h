// Moves textures that exceed the limit (--texture-memory) to an unnamed temporary file and maps
// them from there (mapped_texels.h). Texture lookups read the same bytes as before, so the picture
// is bit-identical. A scene within the limit has no extra cost.
//
// Resident pages belong to the kernel's page cache, which drops them when memory is short. A thread
// of ours also releases this process's pages whenever they exceed the limit. A released page that
// is used again comes from the page cache or the disk.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "io/files/atomic_file.h"
#include "renderer/core/load_progress.h"
#include "renderer/description/scene_description.h"

namespace emberline {

class TextureFile;

class TextureStore {
 public:
  // Adds a decoded image before any code uses its texels. Once the total size exceeds the limit,
  // moves this image and all earlier images of this load to the file, and returns their bytes to
  // the budget. Thread-safe. Throws RenderError if the temporary folder fails.
  void add(const std::shared_ptr<Image>& image, const LoadProgress& progress);
  // Call when all images of this load have been added. Images that are then in memory stay there.
  void finish_load() { in_memory_.clear(); }

 private:
  std::mutex mutex_;
  uint64_t bytes_ = 0;                             // total of all images
  std::vector<std::shared_ptr<Image>> in_memory_;  // images of this load that are still in memory
  std::shared_ptr<TextureFile> file_;              // null while everything fits
};

}  // namespace emberline
