// Fuzzes edits (--edits). The only environment that they can name is the file itself.
#include "fuzz/fuzz.h"
#include "io/json/edits_file.h"

using namespace emberline;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string path = fuzz::write_input(data, size, "edits.json");
  fuzz::allow_errors([&] { read_edits(path); });
  return 0;
}
