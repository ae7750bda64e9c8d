#include "renderer/app/command_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>
#include <utility>

#include "io/files/atomic_file.h"
#include "renderer/app/frame_sink.h"
#include "renderer/app/standard_output.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"
#include "renderer/core/version.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/setting_rules.h"
#include "renderer/engine/setting_table.h"
#include "renderer/lights/light_guide.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/frame_memory.h"
#include "renderer/output/light_layers.h"
#include "renderer/output/plan_pilot.h"
#include "renderer/output/refinement_output.h"
#include "renderer/output/report_page.h"

namespace emberline {
namespace {

void summarize(const RenderOptions& options, const RenderReport& report,
               const std::vector<std::string>& written) {
  const RenderCounters& c = report.counters;
  const double seconds = report.times.render_s;
  const uint64_t samples = c.samples - report.resumed_samples;
  const double fraction = c.samples > 0 ? double(samples) / double(c.samples) : 1.0;
  const auto millions_per_second = [&](double count) {
    return seconds > 0 ? count / seconds * 1e-6 : 0.0;
  };
  log_info(fmt::format("{} {} samples in {} ({:.2f} M samples/s, {:.2f} M rays/s), {:.0f} MiB",
                       c.stopped ? "stopped after" : "rendered", samples, readable_seconds(seconds),
                       millions_per_second(double(samples)),
                       millions_per_second(fraction * double(c.rays.total())),
                       double(peak_rss_bytes()) / 1048576));
  if (samples < c.samples) {
    log_info(fmt::format("resumed from {} samples in the checkpoint", c.samples - samples));
  }
  if (c.clamped.clamps()) {
    log_info(fmt::format("--clamp-indirect removed {:.3g} % of the light",
                         100.0 * c.clamped.fraction()));
  }
  if (report.denoise) log_info(describe(*report.denoise));
  for (const std::string& path : written) log_info("wrote " + path);
  const auto snapshots = std::ranges::count_if(
      report.snapshots, [](const SnapshotReport& snapshot) { return !snapshot.file.empty(); });
  if (snapshots > 0)
    log_info(fmt::format("wrote {} snapshots to {}", snapshots, options.snapshots));
  for (const std::string& feature : report.features) log_verbose("built: " + feature);
}

std::optional<SamplePlanFile> read_sample_plan(const RenderOptions& options,
                                               const LoadLimits& limits) {
  if (options.plan.empty()) return std::nullopt;
  return SamplePlanFile(options, limits);
}

PrepareOptions prepare_options(const RenderOptions& options, const AovSet& aovs,
                               const std::optional<SamplePlanFile>& sample_plan) {
  return {.aovs = aovs,
          .explained = options.explained,
          .keep_tree = !options.trees.empty(),
          .is_extension = !options.extended.empty(),
          .sample_plan = sample_plan ? sample_plan->plan() : nullptr};
}

// By default, the noise threshold applies only to the picture (R G B). Layers for compositing may
// then be noisier.
void suggest_judging(const RenderOptions& options) {
  const bool has_layers = options.light_groups || has_catchers(options);
  if (!options.noise_threshold || !options.judge.empty() || !has_layers ||
      !setting_is_allowed(options, "judge")) {
    return;
  }
  log_info(fmt::format(
      "--noise-threshold judges only R G B, so {} may be noisier; --judge {} includes them",
      has_catchers(options) ? "shadows" : "the layers of the lights", kJudgeDelivered));
}

}  // namespace

CommandFrame::CommandFrame(RenderRun& run, const RenderOptions& options)
    : run_(run),
      options_(options),
      output_settings_(output_settings(options, crop_of(options))),
      sample_plan_(read_sample_plan(options, run.limits)),
      plan_(options, prepare_options(options, output_settings_.aovs, sample_plan_)),
      progress_({}, {}, run.limits),
      memory_(run.limits.memory, MemoryPart::kFilm),
      checkpoint_(options) {
  if (run.first) report_.times.start_s = run.process_s;
  check_output_paths(options, plan_.crop, files_);
  run_.begin();
  if (!options.replay) open_outputs();
  report_.crop = plan_.crop;
  report_.threads = run_.workers->count();
  report_.times.setup_s = run_.wall.seconds();
}

void CommandFrame::open_outputs() {
  reserve_frame(options_, output_settings_, plan_, run_.workers->count(), memory_);
  if (!options_.save_settings.empty()) check_writable(options_.save_settings);
  for (const std::string& path : options_.reports) check_writable(path);
  if (std::ranges::any_of(options_.reports, is_page)) {
    pictures_.emplace(options_, plan_.crop, output_settings_.aovs);
  }
  for (const std::string& path : options_.trees) check_writable(path);
  if (!options_.snapshots.empty()) open_snapshots();
  OutputSettings settings = output_settings_;
  if (is_part(options_)) settings.heatmaps.clear();
  outputs_.emplace(is_part(options_) ? std::vector<std::string>() : options_.outputs, settings,
                   stop_);
  const std::string checkpoint = checkpoint_path(options_);
  if (checkpoint.empty()) return;
  AtomicFile file(checkpoint);  // throws now, before rendering, if the path is not writable
  check_checkpoint(checkpoint, options_.resume);
  if (options_.resume || is_default_checkpoint(options_)) return;
  nlohmann::json head = checkpoint_head(options_, plan_, {}, {});
  head.erase("inputs");  // the input files have not been read yet
  check_overwrite(checkpoint, head);
}

// Also reads the picture of --reference. Its memory is reserved for this frame, and the scene's
// memory for the whole run.
void CommandFrame::open_snapshots() {
  LoadLimits limits = run_.limits;
  limits.memory = run_.limits.memory->child_budget();
  LoadProgress progress({}, {}, limits);
  snapshots_.emplace(options_, plan_.crop, progress);
  reference_memory_ = MemoryReservation(run_.limits.memory, MemoryPart::kTextures,
                                        limits.memory->newly_reserved(), options_.reference);
}

void CommandFrame::load() {
  const Stopwatch load;
  read_pose_.emplace(run_.scene.load(options_, plan_.build, progress_));
  run_.scene.register_inputs(files_);
  if (run_.names) run_.scene.register_inputs(*run_.names);
  run_.on_scene_read();
  report_.times.load_s = load.seconds();
}

void CommandFrame::build() {
  const Stopwatch build;
  const bool needs_build = read_pose_->read.has_value();
  const PosedScene& posed = run_.scene.build(*std::exchange(read_pose_, std::nullopt), progress_);
  const Scene& scene = posed.open->scene();
  camera_ = create_camera(options_, posed.camera_of(options_), scene);
  report_.times.build_s = build.seconds();
  posed.report(report_);
  report_.budget = run_.limits.memory;
  if (needs_build) {
    check_memory_growth(run_.memory_before, *run_.limits.memory, options_.scene);
    log_verbose(fmt::format("loaded in {}, built in {}: {} triangles, {} instances",
                            readable_seconds(report_.times.load_s),
                            readable_seconds(report_.times.build_s), scene.triangle_count(),
                            scene.instance_count()));
  }
  const SceneParts parts = posed.open->parts();
  layers_ = scene_layers(parts, camera_, scene.origin());
  if (parts.light_groups) add_light_groups(*parts.light_groups);
  if (outputs_) outputs_->add_scene(layers_);
  const Stopwatch preparing;
  job_ = plan_.prepare(*posed.open, camera_, stop_.token());
  report_.times.build_s += preparing.seconds();
  const Frame& frame = job_->frame();
  if (frame.guide) report_.features.push_back(frame.guide->describe());
  if (std::string text = frame.indirect.describe(); !text.empty()) {
    report_.features.push_back(std::move(text));
  }
}

void CommandFrame::add_light_groups(const LightGroups& groups) {
  report_.features.push_back(describe(groups));
  report_.light_layers = layers_.lights;
  reserve_lights(options_, output_settings_, plan_, layers_.lights, run_.workers->count(), memory_);
}

void CommandFrame::on_picture_changed(const JobProgress& now, const LivePicture& picture) {
  const double elapsed = clock_->seconds();
  std::vector<PassReport>& passes = report_.passes;
  // A driver estimates a pass's error when it plans the next pass, so `now` has the estimate for
  // the previous pass.
  if (!passes.empty()) passes.back().error_estimate = now.error_estimate;
  if (now.pass_finished) {
    passes.push_back({elapsed, now.samples, std::nullopt});
    if (is_forecast_due(elapsed)) update_forecast(elapsed);
  }
  if (snapshots_) clock_->exclude_time([&] { snapshots_->update(now, picture, elapsed); });
  if (viewer_) viewer_->update(picture, elapsed);
  if (checkpoint_.is_due()) checkpoint_.save(*job_);
}

// A forecast predicts the frame's rendering time. It takes as long as planning a round, so it is
// made only once. With a noise threshold, it is repeated whenever the elapsed time has doubled,
// because the expected number of samples changes.
bool CommandFrame::is_forecast_due(double elapsed_s) const {
  if (report_.resumed_samples > 0) return false;
  return !report_.forecast || (options_.noise_threshold && elapsed_s >= 2 * forecast_at_s_);
}

// The report keeps the first forecast. A later forecast corrects the progress display. It is logged
// only if it is outside the interval that was last logged.
void CommandFrame::update_forecast(double elapsed_s) {
  const std::optional<WorkForecast> work = job_->forecast();
  if (!work) return;
  // Factors for `left_s`, which assumes that the rest of the work is done at the same speed. They
  // are the typical, least and greatest measured values (tests/bench/results/adaptive.md). With a
  // threshold they are higher, because the first samples have missed glints.
  const bool by_threshold = options_.noise_threshold.has_value();
  const double middle = by_threshold ? 1.4 : 0.95, least = by_threshold ? 0.8 : 0.7,
               most = by_threshold ? 4.0 : 1.3;
  constexpr double kShort_s = 5;  // shorter forecasts are logged only with --verbose
  const double left_s = elapsed_s * (work->work - 1);
  const ForecastReport f = {elapsed_s, elapsed_s + middle * left_s, elapsed_s + least * left_s,
                            elapsed_s + most * left_s, work->samples / double(plan_.crop.area())};
  const bool is_new = !logged_forecast_ || f.seconds < logged_forecast_->least_s ||
                      f.seconds > logged_forecast_->most_s;
  if (!report_.forecast) report_.forecast = f;
  expected_s_ = f.seconds;
  forecast_at_s_ = elapsed_s;
  if (!is_new) return;
  logged_forecast_ = f;
  const std::string text =
      fmt::format("expected rendering time: {} ({} to {})", readable_seconds(f.seconds),
                  readable_seconds(f.least_s), readable_seconds(f.most_s));
  f.seconds < kShort_s ? log_verbose(text) : log_info(text);
}

void CommandFrame::resume() {
  const bool has_checkpoint = !checkpoint_path(options_).empty();
  if (!has_checkpoint && !sample_plan_) return;
  LoadProgress progress({}, {}, run_.limits);  // its timeout starts now, after loading
  const nlohmann::json& inputs = run_.scene.inputs(options_, progress);
  const nlohmann::json head = checkpoint_head(options_, plan_, layers_, inputs);
  if (sample_plan_) sample_plan_->check(head);
  if (!has_checkpoint) return;
  checkpoint_.open(head, is_default_checkpoint(options_), take_checkpoint_request,
                   2 * memory_.bytes(), *job_);
  report_.resumed_samples = job_->counters().samples;
}

// Returns the time after which a frame with --resume must stop, so that its checkpoint can be saved
// before the Slurm job ends. A frame that is stopped for this reason counts as unfinished, so that
// Slurm does not consider it done.
std::optional<double> CommandFrame::allotted_seconds() const {
  if (!options_.resume) return std::nullopt;
  const std::optional<double> seconds = slurm_seconds_left();
  if (seconds) {
    log_verbose("--time-limit " + readable_seconds(*seconds) +
                ": the frame stops one minute before SLURM_JOB_END_TIME, with exit code 130");
  }
  return seconds;
}

void CommandFrame::render() {
  if (run_.frame_position) log_info(run_.frame_position->text());
  suggest_judging(options_);
  run_.save_settings();
  if (options_.viewer) viewer_.emplace(options_, plan_.crop, run_.workers->count());
  report_.display = outputs_->display_description();
  if (!run_.graceful) run_.graceful.emplace();
  clock_.emplace();
  run_.arena->execute([&] {
    // With a sample plan or a time budget, the number of samples is not known. The finished buckets
    // or the elapsed time then show the progress.
    const bool is_count_known = !sample_plan_ && plan_.time_budget_s == 0;
    const uint64_t samples_per_pixel = is_count_known ? plan_.samples_per_pixel : 0;
    ProgressDisplay progress(
        uint64_t(double(plan_.crop.area()) * double(samples_per_pixel) * part_of_frame()), stop_,
        time_limit_of(options_), allotted_seconds(),
        run_.frame_position ? run_.frame_position->text() : "",
        run_.progress_file ? &*run_.progress_file : nullptr);
    progress.add_resumed(report_.resumed_samples, 0);
    if (options_.time_budget_s) progress.expect(*options_.time_budget_s);
    FrameSink sink(*this, &progress);
    result_ = job_->render(sink, stop_.token());
    report_.resumed_samples += sink.resumed_samples();
  });
  report_.counters = result_.counters;
  report_.unsampled_pixels = result_.unsampled_pixels;
  checkpoint_.save_if_retained(report_.counters.stopped, stop_.cause(), *job_);
  report_.times.render_s = clock_->seconds();
  report_.times.snapshots_s = clock_->excluded_seconds();
  report_.times.render_cpu_s = clock_->cpu_seconds();
  if (report_.passes.empty() || report_.passes.back().samples < report_.counters.samples) {
    report_.passes.push_back({report_.times.render_s, report_.counters.samples, std::nullopt});
  }
}

// The first stop signal during denoising ends denoising early. If a signal has already ended the
// render, the partial picture is denoised completely.
void CommandFrame::denoise() {
  std::stop_source end;
  std::optional<std::jthread> watcher_thread;
  if (!stop_signalled()) {
    watcher_thread.emplace([&end](const std::stop_token& thread_stop) {
      std::mutex mutex;
      std::condition_variable_any wake;
      std::unique_lock lock(mutex);
      while (!thread_stop.stop_requested() && !stop_signalled()) {
        wake.wait_for(lock, thread_stop, std::chrono::milliseconds(20), [] { return false; });
      }
      if (stop_signalled()) end.request_stop();
    });
  }
  run_.arena->execute([&] { report_.denoise = outputs_->finish_spooled(end.get_token()); });
  denoising_stopped_ = report_.denoise && report_.denoise->stopped;
  if (denoising_stopped_) stop_.request(PixelStop::kUser);
}

void CommandFrame::write() {
  const Stopwatch write;
  outputs_->rendering_ended();
  FrameSink sink(*this, nullptr);
  // `extend` must not replace the complete picture with an incomplete one.
  const auto may_write = [&] { return options_.extended.empty() || !unfinished(); };
  if (may_write()) {
    try {
      run_.arena->execute([&] { job_->deliver(sink); });
      denoise();
    } catch (...) {
      checkpoint_.save_if_unwritten(report_.counters.stopped, *job_);
      throw;
    }
  }
  report_.complete = result_.complete && !denoising_stopped_;
  if (may_write()) {
    outputs_->finish({report_.complete, report_.counters.samples,
                      report_.counters.clamped.fraction(), job_->picture() ? job_->history() : ""},
                     attempts_);
  }
  write_refinement(options_, *job_, attempts_);
  report_.cryptomattes = outputs_->cryptomattes();
  if (viewer_) viewer_->finish(stop_.cause());
  report_.estimator =
      plan_.is_uniform ? "none" : std::string(plan_.driver_settings.adaptive.estimator);
  report_.error_estimate = job_->error_estimate();
  report_.passes.back().error_estimate = report_.error_estimate;
  report_.times.write_s = write.seconds();
  report_.film_bytes = outputs_->film_bytes() + job_->film_bytes() +
                       (pictures_ ? pictures_->bytes() : 0) + (viewer_ ? viewer_->bytes() : 0);
  if (!snapshots_) return;
  const Stopwatch encode;
  run_.arena->execute([&] { report_.snapshots = snapshots_->write(snapshot_attempts_); });
  report_.times.snapshots_s += encode.seconds();
}

std::vector<std::string> CommandFrame::failed_outputs() const {
  std::vector<std::string> failed = attempts_.failed();
  failed.insert(failed.end(), snapshot_attempts_.failed().begin(),
                snapshot_attempts_.failed().end());
  if (retains_checkpoint(options_) && !report_.checkpoint.error.empty()) {
    failed.push_back(report_.checkpoint.file);
  }
  return failed;
}

void CommandFrame::end_checkpoint() {
  if (!checkpoint_.is_open()) return;
  const bool stopped = report_.counters.stopped;
  const bool written = failed_outputs().empty() && !denoising_stopped_;
  report_.checkpoint = checkpoint_.finish(stopped, written, *job_);
  checkpoint_.log_failure(report_.checkpoint);
  if (!report_.checkpoint.error.empty()) return;
  const bool done = !stopped && written;
  if (done && is_part(options_)) {
    log_info(report_.checkpoint.file +
             " has this part of the frame; join the parts with emberline merge");
  }
  if (done) return;
  log_info(report_.checkpoint.file + " has the unfinished frame; " +
           (options_.extended.empty() ? "--resume continues" : "the same command continues") +
           " it");
}

bool CommandFrame::has_holes() const {
  return job_->is_tiled() && result_.unsampled_pixels > 0 && !is_part(options_) &&
         options_.extended.empty();
}

void CommandFrame::report_holes() const {
  if (!has_holes() || stop_.cause() != PixelStop::kTimeLimit) return;
  const std::string message =
      fmt::format("{} of the pixels have no sample and are black; --driver adaptive avoids this",
                  readable_percent(double(result_.unsampled_pixels) / double(plan_.crop.area())));
  options_.strict ? log_error(message) : log_warning(message);
}

int CommandFrame::exit_code() const {
  if (!report_.failed_outputs.empty()) return kExitRenderFailed;
  if (!unfinished()) return kExitDone;
  // A caller that can resume the frame must learn that it is unfinished. Any other frame that
  // reaches its time limit counts as done.
  const bool is_resumable = options_.resume || is_part(options_) || denoising_stopped_;
  if (is_resumable || stop_.cause() == PixelStop::kUser) return kExitStopped;
  return options_.strict && has_holes() ? kExitRenderFailed : kExitDone;
}

int CommandFrame::write_plan(const RenderOptions& planned, const std::string& path) {
  if (report_.counters.stopped) {
    log_warning(path + " was not written, because the command was stopped");
    end_checkpoint();
    return kExitStopped;
  }
  const RenderPlan plan(planned);
  const SamplePlan counts = [&] {
    try {
      return planned_samples(*job_, planned);
    } catch (const RenderError& error) {
      throw RenderError("{}: {}", path, error.what());
    }
  }();
  LoadProgress progress({}, {}, run_.limits);
  const nlohmann::json& inputs = run_.scene.inputs(options_, progress);
  try {
    write_sample_plan(path, checkpoint_head(planned, plan, layers_, inputs), counts);
  } catch (...) {
    checkpoint_.save_if_unwritten(report_.counters.stopped, *job_);
    throw;
  }
  end_checkpoint();
  const auto [least, most] = std::ranges::minmax(counts.counts);
  const auto total =
      double(std::accumulate(counts.counts.begin(), counts.counts.end(), uint64_t{0}));
  log_info(fmt::format("wrote {}: {:.4g} samples per pixel, {} to {} for single pixels", path,
                       total / double(counts.counts.size()), least, most));
  return kExitDone;
}

int CommandFrame::report() {
  end_checkpoint();
  report_.stop_cause = stop_.cause();
  report_.failed_outputs = failed_outputs();
  report_.exit_code = exit_code();
  report_.times.wall_s = run_.wall.seconds();
  report_.times.cpu_s = process_cpu_seconds() - run_.cpu_before_s;
  warn_about_non_finite(report_.counters, options_);
  warn_about_optics(report_.counters.optics);
  report_holes();
  report_.warnings = warnings_so_far();
  write_reports();
  summarize(options_, report_, attempts_.written());
  if (options_.explained) {
    print_result(job_->explain(options_.explained->x, options_.explained->y));
  }
  return report_.exit_code;
}

void CommandFrame::write_reports() {
  for (const std::string& path : options_.reports) {
    const bool written = attempts_.attempt(path, [&] {
      write_file_atomically(path, is_page(path) ? report_page(options_, report_, *pictures_)
                                                : report_json(options_, report_));
    });
    if (!written) report_.exit_code = kExitRenderFailed;
  }
}

std::optional<RenderReport> render_frame(RenderRun& run, const RenderOptions& options) {
  CommandFrame frame(run, options);
  frame.load();
  frame.build();
  if (stop_signalled()) return std::nullopt;
  frame.resume();
  frame.render();
  frame.write();
  frame.report();
  return frame.result();
}

}  // namespace emberline
