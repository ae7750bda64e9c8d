// A library for LD_PRELOAD that makes some calls fail for files whose paths contain BROKEN_PATH.
// BROKEN_CALLS names the calls, BROKEN_ERROR is the errno that they set, and BROKEN_AFTER is how
// many of them succeed before the first one fails.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

static atomic_int g_calls;

static int fails(const char* call, const char* path) {
  const char* part = getenv("BROKEN_PATH");
  const char* calls = getenv("BROKEN_CALLS");
  if (!part || !calls || !strstr(path, part) || !strstr(calls, call)) return 0;
  const char* after = getenv("BROKEN_AFTER");
  if (atomic_fetch_add(&g_calls, 1) < (after ? atoi(after) : 0)) return 0;
  const char* error = getenv("BROKEN_ERROR");
  errno = error ? atoi(error) : EIO;
  return 1;
}

static int fails_for(const char* call, int descriptor) {
  char link[64], path[PATH_MAX];
  snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t size = readlink(link, path, sizeof path - 1);
  if (size < 0) return 0;
  path[size] = '\0';
  return fails(call, path);
}

#define REAL(type, name, ...) ((type(*)(__VA_ARGS__))dlsym(RTLD_NEXT, #name))

// "half" stands for a disk that becomes full: pwrite then writes only half of the bytes.
ssize_t pwrite(int d, const void* bytes, size_t count, off_t at) {
  if (count > 1 && fails_for("half", d)) {
    return REAL(ssize_t, pwrite, int, const void*, size_t, off_t)(d, bytes, count / 2, at);
  }
  if (fails_for("pwrite", d)) return -1;
  return REAL(ssize_t, pwrite, int, const void*, size_t, off_t)(d, bytes, count, at);
}
ssize_t pwrite64(int d, const void* bytes, size_t count, off_t at) { return pwrite(d, bytes, count, at); }
int fsync(int d) { return fails_for("fsync", d) ? -1 : REAL(int, fsync, int)(d); }
int fdatasync(int d) { return fails_for("fdatasync", d) ? -1 : REAL(int, fdatasync, int)(d); }
int ftruncate(int d, off_t size) {
  return fails_for("ftruncate", d) ? -1 : REAL(int, ftruncate, int, off_t)(d, size);
}
int ftruncate64(int d, off_t size) { return ftruncate(d, size); }
int rename(const char* from, const char* to) {
  return fails("rename", to) ? -1 : REAL(int, rename, const char*, const char*)(from, to);
}
