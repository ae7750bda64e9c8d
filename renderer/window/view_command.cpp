#include "renderer/window/view_command.h"

#include "io/file_register.h"
#include "renderer/core/errors.h"
#include "renderer/output/outputs.h"
#include "renderer/window/window.h"

namespace emberline {

int run_view(const ViewOptions& options) {
  FileRegister files;
  if (!options.measure.empty()) files.write("--measure", options.measure);
  if (!options.screenshot.empty()) files.write("--screenshot", options.screenshot);
  if (!options.journal.empty()) files.write("--journal", options.journal);
  if (!options.measure_script.empty()) files.read(options.measure_script, "it is --measure-script");
  register_inputs(options.render, files);
  Window window(options);
  window.run();
  return kExitDone;
}

}  // namespace emberline
