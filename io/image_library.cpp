#include "io/image_library.h"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "io/input_file.h"
#include "renderer/core/errors.h"

namespace emberline {

int ImageLayout::find_channel(const std::string& name) const {
  const auto found = std::ranges::find(channel_names, name);
  return found == channel_names.end() ? -1 : int(found - channel_names.begin());
}

#ifdef EMBERLINE_IMAGES_LINKED

const ImageLibrary& image_library() { return *emberline_image_library(EMBERLINE_VERSION); }
uint64_t image_library_bytes() { return 0; }

#else

namespace {

std::atomic<uint64_t> g_bytes{0};

// Resident memory, proc(5).
uint64_t resident_bytes() {
  const std::string text = read_kernel_text("/proc/self/statm");
  const size_t space = text.find(' ');
  return space == std::string::npos
             ? 0
             : std::strtoull(text.c_str() + space, nullptr, 10) * uint64_t(::sysconf(_SC_PAGESIZE));
}

// From the program's own folder, or else where the system looks.
void* load() {
  constexpr const char* kName = "libemberline_images.so";
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path beside = program.parent_path().parent_path() / "lib" / kName;
  const bool there = !error && std::filesystem::exists(beside, error);
  return ::dlopen(there ? beside.c_str() : kName, RTLD_LAZY | RTLD_LOCAL);
}

const ImageLibrary& find() {
  const uint64_t before = resident_bytes();
  void* const library = load();
  if (!library) throw RenderError(std::string("no images can be read or written: ") + ::dlerror());
  const auto entry = reinterpret_cast<decltype(&emberline_image_library)>(
      ::dlsym(library, "emberline_image_library"));
  const ImageLibrary* const found = entry ? entry(EMBERLINE_VERSION) : nullptr;
  if (!found) throw RenderError("libemberline_images.so is of another version than this program");
  const uint64_t after = resident_bytes();
  g_bytes = after > before ? after - before : 0;
  return *found;
}

}  // namespace

uint64_t image_library_bytes() { return g_bytes; }

const ImageLibrary& image_library() {
  static const ImageLibrary& library = find();
  return library;
}

#endif

}  // namespace emberline
