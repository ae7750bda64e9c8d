// Textures that together take more memory than they may (--texture-memory): their texels lie in a
// temporary file without a name and are mapped from there (mapped_texels.h), so that a lookup reads
// the same bytes, the picture has the same bits, and a scene that fits has nothing of all this.
//
// What of the file is in memory is the kernel's cache, which gives it up when memory is short. A
// thread lets the process's own share go whenever it is above the limit: a page that is asked for
// again is then found in that cache, or on the disk.
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
  // Of an image that was just decoded, before anyone looks at it: puts it into the file, and all
  // those of this load before it, once they are too many. Their bytes go back to the budget.
  // Thread-safe. Throws RenderError for the folder of temporary files.
  void add(const std::shared_ptr<Image>& image, const LoadProgress& progress);
  // All images of this load are there: they stay where they are from now on.
  void end_load() { waiting_.clear(); }

 private:
  std::mutex mutex_;
  uint64_t bytes_ = 0;                           // of all that came
  std::vector<std::shared_ptr<Image>> waiting_;  // of this load, in memory
  std::shared_ptr<TextureFile> file_;            // null as long as they fit
};

}  // namespace emberline
