#include "io/image/library.h"

#include <dlfcn.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <atomic>
#include <filesystem>
#include <system_error>
#include <vector>

#include "io/files/byte_order.h"
#include "io/files/input_file.h"
#include "renderer/core/errors.h"

namespace emberline {

#ifdef EMBERLINE_IMAGES_LINKED

const ImageLibrary& image_library() { return *emberline_image_library(EMBERLINE_VERSION); }
uint64_t image_library_bytes() { return 0; }

#else

namespace {

constexpr const char* kLibraryName = "libemberline_images.so";

std::atomic<uint64_t> g_bytes{0};

// Rejects a truncated library file, which would crash the program when it is mapped. An intact file
// contains all its section headers, which come last (ELF-64).
void check_complete(const std::string& path) {
  const InputFile file(path);
  uint8_t header[64] = {};
  const auto number = [&](size_t offset, size_t count) {
    return little_endian<uint64_t>(header, offset, count);
  };
  const bool read = file.try_read(0, sizeof header, header) == int64_t(sizeof header);
  const uint64_t sections = number(0x28, 8), size = number(0x3a, 2), count = number(0x3c, 2);
  if (!read || sections > file.size() || size * count > file.size() - sections) {
    throw RenderError("cannot read or write images: {} is damaged", path);
  }
}

// Checks in advance that there is enough address space. When memory is short, the constructors of
// OpenImageIO's dependencies abort the program or hang.
void check_address_space() {
  constexpr size_t kRequiredBytes = size_t(700) << 20;
  rlimit space = {}, data = {};
  ::getrlimit(RLIMIT_AS, &space);
  ::getrlimit(RLIMIT_DATA, &data);
  if (space.rlim_cur == RLIM_INFINITY && data.rlim_cur == RLIM_INFINITY) return;
  void* const room = ::mmap(nullptr, kRequiredBytes, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) {
    throw RenderError(
        "cannot read or write images: the image library needs 700 MiB of address space, more than "
        "the shell's limits allow (ulimit -v, ulimit -d)");
  }
  ::munmap(room, kRequiredBytes);
}

// Looks in the folder of the binary that contains this code, then in up to three folders above it:
// the binary may be a renderer library for one CPU architecture, which lies deeper
// (renderer/arches.cmake). Finally looks in the program's ../lib. Returns an empty string if none
// of these folders has the library.
std::string find_bundled_library() {
  namespace fs = std::filesystem;
  std::error_code error;
  Dl_info here = {};
  const bool found = ::dladdr(reinterpret_cast<const void*>(&image_library_bytes), &here) != 0;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  std::vector<fs::path> folders = {program.parent_path().parent_path() / "lib"};
  fs::path folder = found ? fs::path(here.dli_fname) : fs::path();
  for (int i = 0; i < 4 && folder.has_relative_path(); ++i) {
    folder = folder.parent_path();
    folders.insert(folders.end() - 1, folder);
  }
  for (const fs::path& path : folders) {
    if (path.is_absolute() && fs::exists(path / kLibraryName, error))
      return (path / kLibraryName).string();
  }
  return {};
}

// Loads our own copy of the library. If there is none, loads one from the system's search path.
void* open_shared_library() {
  const std::string own = find_bundled_library();
  if (!own.empty()) check_complete(own);
  check_address_space();
  return ::dlopen(own.empty() ? kLibraryName : own.c_str(), RTLD_LAZY | RTLD_LOCAL);
}

const ImageLibrary& load_image_library() {
  const uint64_t before = statm_bytes(StatmField::kResident);
  void* const library = open_shared_library();
  if (!library) throw RenderError(std::string("cannot read or write images: ") + ::dlerror());
  const auto entry = reinterpret_cast<decltype(&emberline_image_library)>(
      ::dlsym(library, "emberline_image_library"));
  const ImageLibrary* const found = entry ? entry(EMBERLINE_VERSION) : nullptr;
  if (!found) throw RenderError("libemberline_images.so and this program have different versions");
  const uint64_t after = statm_bytes(StatmField::kResident);
  g_bytes = after > before ? after - before : 0;
  return *found;
}

}  // namespace

uint64_t image_library_bytes() { return g_bytes; }

const ImageLibrary& image_library() {
  static const ImageLibrary& library = load_image_library();
  return library;
}

#endif

}  // namespace emberline
