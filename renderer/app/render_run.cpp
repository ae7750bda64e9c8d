#include "renderer/app/render_run.h"

#include <fmt/format.h>

#include "io/files/atomic_file.h"
#include "renderer/core/log.h"
#include "renderer/core/version.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/report.h"

namespace emberline {

RenderRun::RenderRun(const RenderOptions& options)
    : limits(limits_of(options.limits, options.scene)),
      scene(options.frames.size() > 1),
      options_(options) {
  log_verbose(
      fmt::format("emberline {} on {}: {}", kEmberlineVersion, host_name(), instruction_sets()));
}

void RenderRun::begin() {
  // The scene may read a file that is there.
  if (progress_file || !is_other_file(options_.progress_file)) begin_progress();
  if (workers) return;
  workers.emplace(options_.threads);
  // An arena of its own: the limit of WorkerThreads cannot give more threads than the machine has
  // cores.
  arena.emplace(workers->count());
}

void RenderRun::begin_progress() {
  if (options_.progress_file.empty() || options_.replay) return;
  if (!progress_file) progress_file.emplace(options_.progress_file);
  if (place) progress_file->begin_frame(*place);
}

void RenderRun::scene_is_read() {
  names.reset();
  if (!progress_file) begin_progress();
}

void RenderRun::save_settings() {
  const std::string& path = options_.save_settings;
  if (path.empty() || settings_saved_) return;
  write_file_atomically(path, settings_json(options_, path));
  settings_saved_ = true;
}

void RenderRun::next_frame() {
  first = false;
  wall = Stopwatch();
  cpu_before_s = process_cpu_seconds();
  if (const PosedScene* posed = scene.posed()) forget_warnings(posed->warnings);
}

void RenderRun::end(int exit_code) {
  if (progress_file) progress_file->finish(exit_code);
}

}  // namespace emberline
