#include "io/texture_store.h"

#include <sys/mman.h>
#include <unistd.h>

#include <charconv>
#include <chrono>
#include <string>

#include "io/input_file.h"

namespace emberline {
namespace {

// How often the process's share is looked at. In this time two threads that read at random map some
// tens of megabytes.
constexpr std::chrono::milliseconds kBetweenLooks(10);

// Pages of files that this process has mapped and touched (Linux: proc_pid_statm(5), "shared").
uint64_t mapped_file_bytes() {
  const std::string text = read_kernel_text("/proc/self/statm");
  const size_t size = text.find(' ');
  const size_t resident = size == std::string::npos ? size : text.find(' ', size + 1);
  uint64_t pages = 0;
  if (resident == std::string::npos) return 0;
  std::from_chars(text.data() + resident + 1, text.data() + text.size(), pages);
  return pages * uint64_t(sysconf(_SC_PAGESIZE));
}

}  // namespace

// The file and what keeps it small in memory. The images hold it.
class TextureFile : public std::enable_shared_from_this<TextureFile> {
 public:
  explicit TextureFile(uint64_t limit) : limit_(limit), others_(mapped_file_bytes()) {}
  ~TextureFile() {
    {
      const std::lock_guard lock(mutex_);
      ends_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
  }
  TextureFile(const TextureFile&) = delete;
  TextureFile& operator=(const TextureFile&) = delete;

  // One at a time.
  void take(Image& image) {
    const uint64_t size = image.byte_count(), page = uint64_t(sysconf(_SC_PAGESIZE));
    file_.write_at(image.texels.data(), size, end_);
    const std::shared_ptr<const std::byte> texels = file_.map(end_, size);
    end_ += (size + page - 1) / page * page;
    {
      const std::lock_guard lock(mutex_);
      maps_.push_back({texels, size});
    }
    if (!thread_.joinable()) thread_ = std::thread([this] { watch(); });
    image.mapped = {shared_from_this(), texels.get()};
    image.texels = std::vector<std::byte>();  // {} would keep the memory
  }

 private:
  struct Map {
    std::shared_ptr<const std::byte> texels;
    uint64_t size;
  };

  void watch() {
    std::unique_lock lock(mutex_);
    while (!wake_.wait_for(lock, kBetweenLooks, [this] { return ends_; })) {
      if (mapped_file_bytes() < others_ + limit_) continue;
      for (const Map& map : maps_) {
        ::madvise(const_cast<std::byte*>(map.texels.get()), map.size, MADV_DONTNEED);
      }
    }
  }

  const uint64_t limit_;
  const uint64_t others_;  // mapped without us
  ScratchFile file_ = ScratchFile::temporary("hold textures in a temporary file");
  uint64_t end_ = 0;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ends_ = false;
  std::vector<Map> maps_;
  std::thread thread_;
};

void TextureStore::add(const std::shared_ptr<Image>& image, const LoadProgress& progress) {
  if (!progress.texture_bytes()) return;
  const std::lock_guard lock(mutex_);
  bytes_ += image->byte_count();
  waiting_.push_back(image);
  if (bytes_ <= *progress.texture_bytes()) return;
  if (!file_) file_ = std::make_shared<TextureFile>(*progress.texture_bytes());
  for (const std::shared_ptr<Image>& next : waiting_) {
    progress.check();
    file_->take(*next);
    progress.budget()->give_back(MemoryPart::kTextures, next->byte_count());
  }
  waiting_.clear();
}

}  // namespace emberline
