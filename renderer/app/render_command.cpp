#include "renderer/app/render_command.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "io/atomic_file.h"
#include "renderer/app/replay.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/names.h"
#include "renderer/core/readable.h"
#include "renderer/core/version.h"
#include "renderer/drivers/adaptive_driver.h"
#include "renderer/drivers/frame_plan.h"
#include "renderer/drivers/setting_table.h"
#include "renderer/film/light_group_sums.h"
#include "renderer/frame/frame_scene.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/frame_memory.h"
#include "renderer/output/light_layers.h"
#include "renderer/output/outputs.h"
#include "renderer/output/refinement_output.h"
#include "renderer/output/remote_viewer.h"
#include "renderer/output/report.h"
#include "renderer/output/report_page.h"
#include "renderer/output/report_pictures.h"
#include "renderer/output/snapshots.h"
#include "renderer/process/process_usage.h"
#include "renderer/process/progress.h"
#include "renderer/process/progress_file.h"
#include "renderer/process/render_clock.h"
#include "renderer/process/slurm_allocation.h"
#include "renderer/process/standard_output.h"
#include "renderer/process/stop_signal.h"
#include "renderer/process/worker_threads.h"
#include "renderer/scene/build_scene.h"

namespace emberline {
namespace {

void summarize(const RenderOptions& options, const RenderReport& report,
               const std::vector<std::string>& written) {
  const FrameCounters& c = report.counters;
  const double seconds = report.times.render_s;
  const uint64_t samples = c.samples - report.earlier_samples;
  const double share = c.samples > 0 ? double(samples) / double(c.samples) : 1.0;
  const auto millions_a_second = [&](double count) {
    return seconds > 0 ? count / seconds * 1e-6 : 0.0;
  };
  log_info(fmt::format("{} {} samples in {} ({:.2f} M samples/s, {:.2f} M rays/s), {:.0f} MiB",
                       c.stopped ? "stopped after" : "rendered", samples, readable_seconds(seconds),
                       millions_a_second(double(samples)),
                       millions_a_second(share * double(c.rays.total())),
                       double(peak_rss_bytes()) / 1048576));
  if (samples < c.samples) {
    log_info(fmt::format("went on from {} samples of the checkpoint", c.samples - samples));
  }
  for (const std::string& path : written) log_info("wrote " + path);
  const auto snapshots = std::ranges::count_if(
      report.snapshots, [](const SnapshotReport& snapshot) { return !snapshot.file.empty(); });
  if (snapshots > 0)
    log_info(fmt::format("wrote {} snapshots to {}", snapshots, options.snapshots));
  for (const std::string& feature : report.features) log_verbose("built: " + feature);
}

// A part has no picture of its own.
void check_part(const RenderOptions& options) {
  if (!is_part(options)) return;
  const auto refuse = [](const char* option) {
    throw UsageError("{}: a part of a frame has no picture of its own; give it for the whole",
                     option);
  };
  if (!options.snapshots.empty()) refuse("--snapshots");
  if (!options.trees.empty()) refuse("--tree");
  if (std::ranges::any_of(options.reports, is_page)) refuse("--report FILE.html");
}

FramePlan plan_of(const RenderOptions& options) {
  FramePlan plan(options);
  plan.driver_settings.explained = options.explained;
  plan.driver_settings.keep_tree = !options.trees.empty();
  plan.driver_settings.extending = !options.extended.empty();
  return plan;
}

// What the file tells is the display's while both live.
class ProgressWatch {
 public:
  ProgressWatch(std::optional<ProgressFile>& file, const ProgressDisplay& display) : file_(file) {
    if (file_) file_->watch([&display] { return display.now(); });
  }
  ~ProgressWatch() {
    if (file_) file_->watch(nullptr);
  }
  ProgressWatch(const ProgressWatch&) = delete;
  ProgressWatch& operator=(const ProgressWatch&) = delete;

 private:
  std::optional<ProgressFile>& file_;
};

// One frame, from options to files and report, in the order of its functions.
class RenderRun {
 public:
  // Finds whatever is wrong with names, ranges and paths, and opens the outputs: they leave no
  // trace if what follows fails.
  explicit RenderRun(const RenderOptions& options);
  void load();
  void build();
  // Takes the checkpoint, and what an earlier run has left in it.
  void resume();
  int replay() { return run_replay(*frame_, *options_.replay); }
  void render();
  void write();
  int report();

 private:
  class Watcher;

  void open_outputs();
  void add_light_groups(const LightGroups& groups);
  void note_picture(const FrameProgress& now, const FramePicture& picture);
  int exit_code() const;
  double part_of_frame() const { return 1.0 / plan_.driver_settings.part.count; }
  std::vector<std::string> failed_outputs() const;
  bool keeps_state() const { return !options_.replay && !checkpoint_path(options_).empty(); }
  void end_checkpoint();
  std::optional<double> allotted_seconds() const;

  const std::optional<double> start_s_ = process_age_seconds();
  const Stopwatch wall_;
  const RenderOptions& options_;
  const uint64_t memory_before_ = peak_rss_bytes();
  RenderReport report_;
  FramePlan plan_;
  FrameRender frame_render_;
  const OutputSettings output_settings_;
  FileRegister files_;
  std::optional<ProgressFile> progress_file_;
  std::optional<WorkerThreads> workers_;
  const LoadLimits limits_;
  LoadProgress progress_;
  uint64_t frame_bytes_ = 0;  // reserved for film and outputs
  nlohmann::json inputs_;     // fingerprints, with a checkpoint
  StopRequest stop_;
  std::optional<SnapshotRecorder> snapshots_;
  std::optional<FrameOutputs> outputs_;
  std::optional<ReportPictures> pictures_;
  SceneDescription description_;
  CameraDescription camera_description_;
  std::unique_ptr<Scene> scene_;
  Camera camera_;
  std::optional<LightGroups> groups_;
  std::optional<Frame> frame_;
  std::optional<RemoteViewer> viewer_;
  std::optional<Checkpoint> checkpoint_;
  std::optional<GracefulStop> graceful_;
  std::optional<tbb::task_arena> arena_;
  std::optional<RenderClock> clock_;
  WriteAttempts attempts_, snapshot_attempts_;
};

RenderRun::RenderRun(const RenderOptions& options)
    : options_(options),
      plan_(plan_of(options)),
      frame_render_(driver_factory(options.driver, plan_.driver_settings)),
      output_settings_(output_settings(options, plan_.crop)),
      limits_(limits_of(options.limits, options.scene)),
      progress_({}, {}, limits_) {
  report_.times.start_s = start_s_;
  log_verbose(
      fmt::format("emberline {} on {}: {}", kEmberlineVersion, host_name(), instruction_sets()));
  plan_.aovs = output_settings_.aovs;
  check_output_paths(options, plan_.crop, files_);
  check_refinement_options(options, plan_);
  check_light_layers(options);
  check_part(options);
  if (!options.progress_file.empty() && !options.replay)
    progress_file_.emplace(options.progress_file);
  workers_.emplace(options.threads);
  // An arena of its own: the limit of WorkerThreads cannot give more threads than the machine has
  // cores.
  arena_.emplace(workers_->count());
  if (!options.replay) open_outputs();
  report_.crop = plan_.crop;
  report_.threads = workers_->count();
  report_.times.setup_s = wall_.seconds();
}

void RenderRun::open_outputs() {
  frame_bytes_ = frame_bytes(options_, output_settings_, frame_render_);
  reserve_frame(frame_bytes_, plan_.crop, *limits_.memory);
  if (!options_.save_settings.empty()) check_writable(options_.save_settings);
  for (const std::string& path : options_.reports) check_writable(path);
  if (std::ranges::any_of(options_.reports, is_page)) {
    pictures_.emplace(options_.display, plan_.crop, output_settings_.aovs);
  }
  for (const std::string& path : options_.trees) check_writable(path);
  if (!options_.snapshots.empty()) snapshots_.emplace(options_, plan_.crop, progress_);
  OutputSettings settings = output_settings_;
  if (is_part(options_)) settings.heatmaps.clear();
  outputs_.emplace(is_part(options_) ? std::vector<std::string>() : options_.outputs, settings,
                   stop_);
  const std::string checkpoint = checkpoint_path(options_);
  if (!checkpoint.empty()) AtomicFile file(checkpoint);  // throws what the first write would
}

void RenderRun::load() {
  const Stopwatch load;
  if (keeps_state()) inputs_ = input_fingerprints(options_, progress_);
  SceneEdits edits = load_edits(options_, progress_);
  description_ = load_scene(options_, progress_, edits.variant.has_value(), need_tangents(edits));
  if (!edits.environment.file.empty()) {
    files_.read(edits.environment.file, "it is the environment of --edits");
  }
  files_.read(description_.files, "the scene reads");
  choose_variant(options_, description_, edits);
  if (edits != SceneEdits() || options_.light_groups) apply(edits, description_);
  report_.times.load_s = load.seconds();
  camera_description_ = choose_camera(options_, description_, edits);
  report_.camera = camera_description_.name;
  report_.coverage = description_.coverage;
  report_.repairs = description_.repairs;
}

void RenderRun::build() {
  if (options_.light_groups) groups_.emplace(outline(description_));
  const Stopwatch build;
  scene_ = build_scene(std::move(description_), plan_.build, progress_);
  camera_ = create_camera(options_, camera_description_, *scene_);
  report_.times.build_s = build.seconds();
  report_.features = scene_->features();
  report_.memory = scene_->memory();
  report_.budget = limits_.memory;
  check_growth(memory_before_, *limits_.memory, options_.scene);
  if (groups_) add_light_groups(*groups_);
  log_verbose(fmt::format("loaded in {}, built in {}: {} triangles, {} instances",
                          readable_seconds(report_.times.load_s),
                          readable_seconds(report_.times.build_s), scene_->triangle_count(),
                          scene_->instance_count()));
  frame_.emplace(plan_.frame(*scene_, camera_, groups_ ? &*groups_ : nullptr));
}

void RenderRun::add_light_groups(const LightGroups& groups) {
  if (!frame_render_.by_tiles()) {
    const uint64_t copies = keeps_state() ? 2 : 1;
    const uint64_t bytes = copies * LightGroupSums::bytes_per_pixel(groups.list().size());
    const uint64_t all = bytes_of(uint64_t(plan_.crop.area()), bytes);
    reserve_frame(all, plan_.crop, *limits_.memory);
    frame_bytes_ += all;
  }
  report_.features.push_back(describe(groups));
  if (outputs_) outputs_->add_light_layers(light_layer_names(groups.list()));
}

// Files and report get finished tiles; while it renders progress is shown, passes are noted,
// snapshots taken and a viewer kept informed.
class RenderRun::Watcher final : public FrameObserver {
 public:
  // Without a display, of a frame that is rendered and is only delivered.
  Watcher(RenderRun& run, ProgressDisplay* progress) : run_(run), progress_(progress) {}

  void tile_finished(const FilmTile& tile) override {
    write(tile);
    // Buckets are finished one by one, so their pixels tell how far a threshold's frame has come.
    if (progress_ && run_.frame_render_.by_tiles()) progress_->add_share(share(tile));
  }
  void tile_loaded(const FilmTile& tile, uint64_t samples) override {
    write(tile);
    earlier_samples_ += samples;
    if (progress_) progress_->add_earlier(samples, share(tile));
  }
  void samples_loaded(uint64_t count) override {
    earlier_samples_ += count;
    if (progress_) progress_->add_earlier(count, 0);
  }
  uint64_t earlier_samples() const { return earlier_samples_; }
  void write(const FilmTile& tile) {
    run_.outputs_->tile_finished(tile);
    if (run_.pictures_) run_.pictures_->add(tile);
    if (run_.viewer_) run_.viewer_->add(tile);
  }
  void samples_finished(uint64_t count) override {
    if (!progress_) return;
    if (!begun_.load(std::memory_order_relaxed) && !begun_.exchange(true)) {
      RenderTimes& times = run_.report_.times;
      times.first_sample_s = process_age_seconds().value_or(run_.wall_.seconds());
      times.first_sample_cpu_s = process_cpu_seconds();
    }
    progress_->add(count);
  }
  void picture_changed(const FrameProgress& now, const FramePicture& picture) override {
    if (progress_) run_.note_picture(now, picture);
  }
  void cut_short() override {
    if (run_.checkpoint_) run_.checkpoint_->save(run_.frame_render_);
  }
  bool picture_wanted() const override {
    if (run_.checkpoint_ && run_.checkpoint_->wanted()) return true;
    if (!progress_ || (!run_.snapshots_ && !run_.viewer_)) return false;
    const double elapsed = run_.clock_->seconds();
    return (run_.snapshots_ && run_.snapshots_->wanted(elapsed)) ||
           (run_.viewer_ && run_.viewer_->wanted(elapsed));
  }
  std::optional<uint64_t> picture_wanted_at() const override {
    return progress_ && run_.snapshots_ ? run_.snapshots_->wanted_at() : std::nullopt;
  }
  PixelStop stop_cause() const override { return run_.stop_.cause(); }

 private:
  double share(const FilmTile& tile) const {
    return double(tile.rect().area()) / (double(run_.plan_.crop.area()) * run_.part_of_frame());
  }

  RenderRun& run_;
  ProgressDisplay* const progress_;
  std::atomic<bool> begun_{false};
  std::atomic<uint64_t> earlier_samples_{0};
};

void RenderRun::note_picture(const FrameProgress& now, const FramePicture& picture) {
  const double elapsed = clock_->seconds();
  std::vector<PassReport>& passes = report_.passes;
  // A driver looks at a finished pass when it plans the next one: what it estimates now is the
  // error of the picture at the end of the last pass.
  if (!passes.empty()) passes.back().error_estimate = now.error_estimate;
  if (now.pass_finished) passes.push_back({elapsed, now.samples, std::nullopt});
  if (snapshots_) clock_->exclude_time([&] { snapshots_->look(now, picture, elapsed); });
  if (viewer_) viewer_->look(picture, elapsed);
  if (checkpoint_ && checkpoint_->wanted()) checkpoint_->save(frame_render_);
}

void RenderRun::resume() {
  const std::string path = checkpoint_path(options_);
  if (path.empty()) return;
  if (inputs_ != input_fingerprints(options_, progress_)) {
    throw InputError(options_.scene, "its files have changed while they were read; start again");
  }
  const auto layers = groups_ ? light_layer_names(groups_->list()) : std::vector<std::string>();
  const nlohmann::json head = checkpoint_head(options_, plan_, layers, inputs_);
  const CheckpointOptions kept = {path, frame_render_.by_tiles(), options_.resume,
                                  options_.checkpoint_interval_s, options_.extended};
  checkpoint_.emplace(kept, head);
  if (options_.resume && options_.extended.empty() && !checkpoint_->goes_on()) {
    log_info(path + " has nothing to go on with; the frame begins anew");
  }
  if (frame_render_.by_tiles()) return frame_render_.keep_tiles(&*checkpoint_);
  frame_render_.resumable(*frame_);
  checkpoint_->copies(frame_render_.film_bytes());
  const auto state = checkpoint_->state(2 * frame_bytes_);
  const auto finished = state ? std::nullopt : checkpoint_->finished_state(2 * frame_bytes_);
  try {
    if (state) frame_render_.load(*state);
    if (finished) frame_render_.extend(*finished);
  } catch (const InputError& error) {
    throw InputError(state ? path : options_.extended, error.what());
  }
  report_.earlier_samples = frame_render_.counters().samples;
}

// A frame that can go on stops in time to be saved. It is not done then: whoever waits for this job
// must not take it for that.
std::optional<double> RenderRun::allotted_seconds() const {
  if (!options_.resume) return std::nullopt;
  const std::optional<double> seconds = slurm_seconds_left();
  if (seconds) {
    log_verbose("--time-limit " + readable_seconds(*seconds) +
                ": a minute before SLURM_JOB_END_TIME, with exit code 130");
  }
  return seconds;
}

void RenderRun::render() {
  if (!options_.save_settings.empty()) {
    write_file_atomically(options_.save_settings, settings_json(options_, options_.save_settings));
  }
  if (options_.viewer) viewer_.emplace(options_, plan_.crop, workers_->count());
  report_.display = outputs_->display_description();
  graceful_.emplace();
  clock_.emplace();
  arena_->execute([&] {
    ProgressDisplay progress(
        uint64_t(double(plan_.crop.area()) * frame_->samples_per_pixel * part_of_frame()), stop_,
        options_.time_limit_s, allotted_seconds());
    progress.add_earlier(report_.earlier_samples, 0);
    Watcher watcher(*this, &progress);
    const ProgressWatch watch(progress_file_, progress);
    report_.counters = frame_render_.render(*frame_, watcher, stop_.token());
    report_.earlier_samples += watcher.earlier_samples();
  });
  const bool by_tiles = frame_render_.by_tiles();
  if (checkpoint_ && !by_tiles && !report_.counters.stopped && keeps_checkpoint(options_)) {
    frame_render_.end(stop_.cause());
    checkpoint_->save(frame_render_);
  }
  report_.times.render_s = clock_->seconds();
  report_.times.snapshots_s = clock_->left_out_seconds();
  report_.times.render_cpu_s = clock_->cpu_seconds();
  if (report_.passes.empty() || report_.passes.back().samples < report_.counters.samples) {
    report_.passes.push_back({report_.times.render_s, report_.counters.samples, std::nullopt});
  }
}

void RenderRun::write() {
  const Stopwatch write;
  outputs_->rendering_ended();
  Watcher watcher(*this, nullptr);
  // A picture that is whole does not give way to one that is not.
  const bool written = options_.extended.empty() || !report_.counters.stopped;
  if (written) {
    arena_->execute([&] { frame_render_.deliver(watcher); });
    const bool complete = frame_render_.is_complete(report_.counters, stop_.cause());
    outputs_->finish({complete, report_.counters.samples}, attempts_);
  }
  write_refinement(options_, frame_render_, attempts_);
  if (viewer_) viewer_->finish(stop_.cause());
  report_.estimator = plan_.even ? "none" : std::string(plan_.driver_settings.adaptive.estimator);
  report_.error_estimate = frame_render_.error_estimate();
  report_.passes.back().error_estimate = report_.error_estimate;
  report_.times.write_s = write.seconds();
  report_.film_bytes = outputs_->film_bytes() + frame_render_.film_bytes() +
                       (pictures_ ? pictures_->bytes() : 0) + (viewer_ ? viewer_->bytes() : 0);
  if (!snapshots_) return;
  const Stopwatch encode;
  arena_->execute([&] { report_.snapshots = snapshots_->write(snapshot_attempts_); });
  report_.times.snapshots_s += encode.seconds();
}

std::vector<std::string> RenderRun::failed_outputs() const {
  std::vector<std::string> failed = attempts_.failed();
  failed.insert(failed.end(), snapshot_attempts_.failed().begin(),
                snapshot_attempts_.failed().end());
  if (keeps_checkpoint(options_) && !report_.checkpoint.whole) {
    failed.push_back(report_.checkpoint.file);
  }
  return failed;
}

// It stays where there is something to go on with: a frame that is not done, or not written.
void RenderRun::end_checkpoint() {
  if (!checkpoint_) return;
  const bool keep = keeps_checkpoint(options_);
  const bool written = failed_outputs().empty();
  const bool done = !report_.counters.stopped && written;
  if (!written && !report_.counters.stopped && !keep && !frame_render_.by_tiles()) {
    checkpoint_->save(frame_render_);
  }
  report_.checkpoint = checkpoint_->finish(done, !done || keep);
  if (!report_.checkpoint.whole) return;
  if (done && is_part(options_)) {
    log_info(report_.checkpoint.file + " has this part of the frame, for `emberline merge`");
  }
  if (done) return;
  log_info(report_.checkpoint.file + " has what is done; " +
           (options_.extended.empty() ? "--resume goes" : "the same command goes") + " on with it");
}

int RenderRun::exit_code() const {
  if (!report_.failed_outputs.empty()) return kExitRenderFailed;
  if (!report_.counters.stopped) return kExitDone;
  // Who goes on with a frame until it is done has to know that it is not. Without that, a time
  // limit is one way to be done.
  const bool goes_on = options_.resume || is_part(options_);
  return goes_on || stop_.cause() == PixelStop::kUser ? kExitStopped : kExitDone;
}

int RenderRun::report() {
  end_checkpoint();
  report_.stop_cause = stop_.cause();
  report_.failed_outputs = failed_outputs();
  report_.exit_code = exit_code();
  report_.times.wall_s = wall_.seconds();
  report_.times.cpu_s = process_cpu_seconds();
  warn_of_non_finite(report_.counters, options_.seed);
  report_.warnings = warnings_so_far();
  for (const std::string& path : options_.reports) {
    const bool written = attempts_.attempt(path, [&] {
      write_file_atomically(path, is_page(path) ? report_page(options_, report_, *pictures_)
                                                : report_json(options_, report_));
    });
    if (!written) report_.exit_code = kExitRenderFailed;
  }
  summarize(options_, report_, attempts_.written());
  if (options_.explained) {
    const auto& adaptive = dynamic_cast<const AdaptiveDriver&>(*frame_render_.driver());
    print_result(
        adaptive.explain(frame_render_.film(), options_.explained->x, options_.explained->y));
  }
  if (progress_file_) {
    progress_file_->finish(report_.exit_code);
  }
  return report_.exit_code;
}

}  // namespace

int run_render(const RenderOptions& options) {
  if (options.outputs.empty() && !options.replay) {
    throw UsageError("render needs an output: -o FILE.exr (or .png, .jpg)");
  }
  RenderRun run(options);
  run.load();
  run.build();
  if (options.replay) return run.replay();
  run.resume();
  run.render();
  run.write();
  return run.report();
}

}  // namespace emberline
