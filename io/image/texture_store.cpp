#include "io/image/texture_store.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <thread>

#include "io/files/input_file.h"
#include "renderer/core/mapped_texels.h"

namespace emberline {
namespace {

// The interval at which the size of the resident pages is checked. In one interval, two threads
// with random lookups can map a few tens of megabytes.
constexpr std::chrono::milliseconds kCheckInterval(10);

// Returns the size of the resident pages of all files that this process maps.
uint64_t mapped_file_bytes() { return statm_bytes(StatmField::kShared); }

}  // namespace

// Owns the file and the thread that limits its resident pages. The images share ownership of the
// TextureFile.
class TextureFile : public std::enable_shared_from_this<TextureFile> {
 public:
  explicit TextureFile(uint64_t limit) : limit_(limit), unrelated_bytes_(mapped_file_bytes()) {}
  ~TextureFile() {
    {
      const std::lock_guard lock(mutex_);
      is_stopping_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
  }
  TextureFile(const TextureFile&) = delete;
  TextureFile& operator=(const TextureFile&) = delete;

  // Not thread-safe.
  void store_image(Image& image) {
    const uint64_t size = image.byte_count(), page = uint64_t(sysconf(_SC_PAGESIZE));
    write_tiled(image);
    const auto mapped = std::make_shared<const MappedTexels>(file_.map(end_, size), size);
    end_ += (size + page - 1) / page * page;
    {
      const std::lock_guard lock(mutex_);
      maps_.push_back(mapped);
    }
    if (!thread_.joinable()) thread_ = std::thread([this] { limit_resident_pages(); });
    image.mapped = {shared_from_this(), mapped.get()};
    image.texels = std::vector<std::byte>();  // {} would keep the capacity
  }

 private:
  void write_tiled(const Image& image) {
    const size_t width = size_t(image.width), height = size_t(image.height), side = kTileSide;
    const size_t texel = size_t(image.byte_count() / (width * height)), row = texel * width;
    std::vector<std::byte> tiles(row * std::min(side, height));
    for (size_t top = 0; top < height; top += side) {
      const size_t rows = std::min(side, height - top);
      std::byte* to = tiles.data();
      for (size_t left = 0; left < width; left += side) {
        const size_t count = texel * std::min(side, width - left);
        const std::byte* from = image.texels.data() + top * row + left * texel;
        for (size_t y = 0; y < rows; ++y, from += row, to += count) std::copy_n(from, count, to);
      }
      file_.write_at(tiles.data(), rows * row, end_ + top * row);
    }
  }

  void limit_resident_pages() {
    std::unique_lock lock(mutex_);
    while (!wake_.wait_for(lock, kCheckInterval, [this] { return is_stopping_; })) {
      if (mapped_file_bytes() < unrelated_bytes_ + limit_) continue;
      for (const auto& mapped : maps_) mapped->release_pages();
    }
  }

  const uint64_t limit_;
  const uint64_t unrelated_bytes_;  // resident pages of other mapped files
  ScratchFile file_ = ScratchFile::temporary("store textures in a temporary file");
  uint64_t end_ = 0;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool is_stopping_ = false;
  std::vector<std::shared_ptr<const MappedTexels>> maps_;
  std::thread thread_;
};

void TextureStore::add(const std::shared_ptr<Image>& image, const LoadProgress& progress) {
  if (!progress.texture_bytes()) return;
  const std::lock_guard lock(mutex_);
  bytes_ += image->byte_count();
  in_memory_.push_back(image);
  if (bytes_ <= *progress.texture_bytes()) return;
  if (!file_) file_ = std::make_shared<TextureFile>(*progress.texture_bytes());
  while (!in_memory_.empty()) {
    progress.check();
    file_->store_image(
        *in_memory_.back());  // throws if the disk is full; the next image tries again
    progress.budget()->release(MemoryPart::kTextures, in_memory_.back()->byte_count());
    in_memory_.pop_back();
  }
}

}  // namespace emberline
