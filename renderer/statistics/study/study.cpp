#include "renderer/statistics/study/study.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <vector>

#include "io/files/atomic_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/frame_memory.h"
#include "renderer/output/outputs.h"
#include "renderer/output/plan_pilot.h"
#include "renderer/output/report.h"
#include "renderer/output/rgb_file.h"
#include "renderer/statistics/study/files.h"
#include "renderer/statistics/study/folder.h"
#include "renderer/statistics/study/page.h"
#include "renderer/statistics/study/pictures.h"
#include "renderer/statistics/study/plan.h"
#include "renderer/statistics/study/reference.h"
#include "renderer/statistics/study/renderer.h"
#include "renderer/statistics/study/settings.h"
#include "renderer/statistics/study_summary.h"

namespace emberline {
namespace {

constexpr uint32_t kDefaultSeeds = 5;
// The reference has this many times the samples of the largest budget. Its variance is therefore
// 1/64 of that of the best picture. This matters for metrics from which the reference's noise is
// not removed.
constexpr uint32_t kReferenceFactor = 64;
// Offsets from the first seed to the seeds of the reference and of the warm-up. No run uses these
// seeds, because the maximum of --seeds is far smaller than the offsets.
constexpr uint32_t kReferenceSeed = 0x40000000u, kWarmUpSeed = 0x80000000u;
// Target time of the last frame of a warm-up, in seconds. If budgets are in seconds, the target is
// at least this fraction of the largest budget.
constexpr double kWarmUpSeconds = 0.3, kWarmUpFraction = 0.1;
constexpr uint32_t kMaxWarmUpSamples = 1024;
// A frame that ends by time may take up to this many times the samples that its pace predicts.
constexpr double kPaceMargin = 4;

uint32_t to_samples(double samples) {
  return uint32_t(std::clamp(samples, 1.0, double(kMaxSamples)));
}

StudyRun failed_run(const std::string& reason) {
  StudyRun run;
  run.status = StudyRunStatus::kFailed;
  run.reason = reason;
  return run;
}

// Reads the picture of --reference. Called before anything slow, so that a bad file is reported at
// once.
std::optional<RgbImage> read_reference(const StudyOptions& options, const LoadLimits& limits) {
  if (options.reference.empty()) return std::nullopt;
  const RenderOptions& frame = options.frame;
  return reference_pixels(read_rgb(options.reference, LoadProgress({}, {}, limits)),
                          "the frame to measure", crop_of(frame), frame.width, frame.height);
}

// Call prepare(), render() and, if has_reference() is true, write_results(), in this order. Call
// all of them on the same thread and in its TBB arena.
class Study {
 public:
  // Loads the scene and opens the folder. Throws UsageError, InputError or RenderError for invalid
  // options. `threads` is only recorded in the results. `options` and `plan` must outlive the
  // study.
  Study(const StudyOptions& options, const StudyPlan& plan, FileRegister& files, int threads)
      : options_(options),
        plan_(plan),
        seeds_(options.seeds.value_or(kDefaultSeeds)),
        limits_(limits_of(options.frame.limits, options.frame.scene)),
        given_reference_(read_reference(options, limits_)),
        folder_(options.folder),
        renderer_(options.frame, options.motion, limits_, files),
        pictures_(folder_, options.frame, renderer_.crop()),
        frame_key_(frame_key(options.frame, limits_)),
        memory_(limits_.memory, MemoryPart::kFilm) {
    reserve_frames();
    folder_.begin(study_key(frame_key_, options, plan, limits_), file_names(), options.restart);
    if (!options.cache.empty()) {
      std::error_code error;
      std::filesystem::create_directories(options.cache, error);
      check_writable((std::filesystem::path(options.cache) / "reference.json").string());
    }
    describe_settings(threads);
  }

  // Warms up, and measures the pace of each method in doing so. Then finds the reference and the
  // runs that were finished before this study was resumed.
  void prepare() {
    prepare_pace();
    find_reference();
    find_finished_runs();
    if (reference_.picture || (reference_.halves[0] && reference_.halves[1])) return;
    double pace = 1;
    for (const auto& [id, value] : pace_.samples_per_s) pace = std::max(pace, value);
    const uint32_t samples = results_.reference.samples_per_pixel;
    log_info(fmt::format(
        "rendering the reference: {} samples per pixel, about {} (use `reference-spp` for fewer)",
        samples, readable_seconds(double(renderer_.pixels()) * samples / pace)));
  }

  // Returns the number of samples that render() will take. For runs that end by time, this is an
  // estimate.
  uint64_t remaining_samples() const {
    double samples = options_.motion ? kMotionSamples : 0;
    for (const auto& half : reference_.halves) {
      if (!half && !reference_.picture) samples += reference_.half_samples;
    }
    for (uint32_t k = 0; k < seeds_; ++k) {
      for (size_t m = 0; m < plan_.methods.size(); ++m) {
        const PlannedMethod& method = plan_.methods[m];
        if (!method.unsupported_reason.empty() || find_run(results_, m, options_.frame.seed + k))
          continue;
        for (const double budget : plan_.budgets) {
          if (method.separate || budget == plan_.budgets.back()) {
            samples += samples_for(method, budget) + pilot_samples(method, budget);
          }
        }
      }
    }
    return uint64_t(samples) * renderer_.pixels();
  }

  // See RenderStudy.
  void render(const std::function<void(uint64_t)>& on_samples, std::stop_token stop) {
    stop_ = std::move(stop);
    renderer_.on_samples(on_samples);
    results_.complete = ensure_reference() && execute_runs();
    renderer_.on_samples({});
  }

  // Returns false if the study was stopped before the reference was complete. In this case there
  // are no results.
  bool has_reference() const { return !results_.reference.exr.empty(); }
  // Writes study.csv, study.json and study.html.
  void write_results(WriteAttempts& attempts) {
    std::ranges::sort(results_.runs, {},
                      [](const StudyRun& run) { return std::pair(run.seed, run.method); });
    for (size_t m = 0; m < plan_.methods.size(); ++m) {
      const StudyRun* first = find_run(results_, m, options_.frame.seed);
      if (!first) continue;
      StudyMethod::Pictures& pictures = results_.methods[m].pictures;
      pictures = StudyPictures::names(plan_.methods[m].id);
      pictures.seed = first->seed;
      pictures.mean_samples = first->checkpoints.back().mean_samples;
      pictures.wall_s = first->checkpoints.back().wall_s;
    }
    const auto write = [&](const char* name, const auto& text) {
      const std::string path = folder_.path(name);
      attempts.attempt(path, [&] { write_file_atomically(path, text(results_)); });
    };
    write("study.csv", [](const StudyResults& r) { return study_csv(r); });
    write("study.json", study_json);
    write("study.html", [&](const StudyResults& r) { return study_page(r, options_.folder); });
  }

  const StudyResults& results() const { return results_; }

 private:
  struct Reference {
    std::optional<ReferencePicture> picture;
    std::array<std::optional<ReferenceHalf>, 2> halves;
    std::array<ReferenceRequest, 2> requests;
    uint32_t half_samples = 0;
  };

  void reserve_frames() {
    uint64_t maximum = 0;
    for (const PlannedMethod& method : plan_.methods) {
      if (!method.unsupported_reason.empty()) continue;
      maximum =
          std::max(maximum, renderer_.frame_bytes(frame_options(method, 1, options_.frame.seed),
                                                  plan_.budgets.size()));
    }
    // The memory per pixel for the channels of both halves, and for the pictures of the halves and
    // of their mean. Each of these pictures is stored in linear and in display-encoded form.
    const uint64_t reference =
        2 * sizeof(float) * film_channels(study_reference_aovs()).size() + 6 * 3 * sizeof(float);
    const uint64_t references = bytes_of(renderer_.pixels(), reference + kComparisonBytesPerPixel);
    reserve_pixels(maximum + references, renderer_.crop(), memory_);
  }

  // Returns the names of all files that the study writes, except the settings, the pace and the
  // halves of the reference.
  std::vector<std::string> file_names() const {
    std::vector<std::string> names = {"study.csv", "study.json", "study.html",
                                      StudyPictures::kReferenceExr, StudyPictures::kReferencePng};
    for (const PlannedMethod& method : plan_.methods) {
      const StudyMethod::Pictures pictures = StudyPictures::names(method.id);
      names.insert(names.end(), {pictures.exr, pictures.png, pictures.flip_png});
      for (uint32_t k = 0; k < seeds_; ++k) {
        names.push_back(StudyFolder::run_name(method.id, options_.frame.seed + k));
      }
    }
    return names;
  }

  void describe_settings(int threads) {
    StudySettings& s = results_.settings;
    s.scene = options_.frame.scene;
    s.command_line = options_.frame.command_line;
    s.width = renderer_.crop().width();
    s.height = renderer_.crop().height();
    s.frame = frame_settings(options_.frame);
    s.by_time = plan_.by_time;
    s.budgets = plan_.budgets;
    s.first_seed = options_.frame.seed;
    s.seeds = seeds_;
    s.threads = threads;
    s.baseline = plan_.baseline;
    s.versions = library_versions();
    for (const PlannedMethod& planned : plan_.methods) results_.methods.push_back(planned.method);
  }

  // Measures the pace of each method. This also warms up caches and threads before the first run.
  void prepare_pace() {
    StudyPace measured;
    for (const PlannedMethod& method : plan_.methods) {
      if (!method.unsupported_reason.empty()) continue;
      try {
        measured.samples_per_s[method.id] = warm_up(method);
      } catch (const std::exception&) {
        measured.samples_per_s[method.id] = 1;  // its runs will report the error
      }
    }
    pace_ = folder_.read_pace().value_or(StudyPace());
    pace_.samples_per_s.merge(measured.samples_per_s);  // keeps paces measured earlier
    if (pace_.reference_spp == 0) pace_.reference_spp = reference_samples();
    folder_.write_pace(pace_);
  }

  // Renders frames with more and more samples until a frame takes long enough. Returns its samples
  // per second.
  double warm_up(const PlannedMethod& method) const {
    const double largest = plan_.budgets.back();
    const double target =
        plan_.by_time ? std::max(kWarmUpSeconds, kWarmUpFraction * largest) : kWarmUpSeconds;
    const uint32_t maximum =
        plan_.by_time ? kMaxSamples : std::min(kMaxWarmUpSamples, to_samples(largest));
    for (uint32_t samples = 1;; samples *= 2) {
      const RenderOptions frame = frame_options(method, samples, options_.frame.seed + kWarmUpSeed);
      const std::optional<StudyPicture> picture = renderer_.render(frame, aovs_of(frame), {});
      if (picture->wall_s >= target || 2 * samples > maximum) {
        return double(picture->samples) / std::max(1e-6, picture->wall_s);
      }
    }
  }

  // Returns the number of samples per pixel that both halves of the reference have together.
  uint32_t reference_samples() const {
    double maximum = 1;
    for (const PlannedMethod& method : plan_.methods)
      maximum = std::max(maximum, samples_in_largest_budget(method));
    const uint32_t sufficient =
        to_samples(kReferenceFactor * std::exp2(std::ceil(std::log2(maximum))));
    const uint32_t target = options_.reference_spp.value_or(
        plan_.by_time ? sufficient : to_samples(kReferenceFactor * maximum));
    if (double(target) < kReferenceFactor * maximum) {
      log_warning(
          fmt::format("the reference has only {:.3g} times the samples of the largest budget; "
                      "below {} times, its noise shows in FLIP and percentiles",
                      double(target) / maximum, kReferenceFactor));
    }
    return target;
  }

  // Uses --reference if it is given; otherwise looks for the halves in the cache.
  void find_reference() {
    StudyReference& info = results_.reference;
    if (given_reference_) {
      info.file = options_.reference;
      reference_.picture.emplace(*given_reference_);
      return;
    }
    reference_.half_samples = (pace_.reference_spp + 1) / 2;
    info.driver = "bucket";
    info.sampler = plan_.reference_sampler;
    info.two_halves = true;
    info.samples_per_pixel = 2 * reference_.half_samples;
    for (uint32_t half = 0; half < 2; ++half) {
      ReferenceRequest& request = reference_.requests[half];
      request.options = options_.frame;
      request.options.driver = info.driver;
      request.options.sampler = info.sampler;
      request.options.spp = reference_.half_samples;
      request.options.seed = info.seeds[half] = options_.frame.seed + kReferenceSeed + half;
      request.folder = options_.cache.empty() ? folder_.path("reference") : options_.cache;
      request.key = reference_key(frame_key_, request.options);
      if (options_.cache.empty()) {
        std::vector<std::string> files = reference_files(request);
        for (std::string& file : files) file.insert(0, "reference/");
        folder_.claim(files);
      } else {
        check_cached_files(request);
      }
      reference_.halves[half] = read_reference_half(request, renderer_.crop());
    }
  }

  // Returns false if the study was stopped.
  bool ensure_reference() {
    if (!reference_.picture) {
      for (size_t i = 0; i < 2; ++i) {
        std::optional<ReferenceHalf>& half = reference_.halves[i];
        if (!half) half = render_reference_half(renderer_, reference_.requests[i], stop_);
        if (!half) return false;
      }
      const std::array<ReferenceHalf, 2> halves = {*reference_.halves[0], *reference_.halves[1]};
      reference_.picture.emplace(reference_picture(halves[0], renderer_.crop()),
                                 reference_picture(halves[1], renderer_.crop()));
      results_.limits = reference_limits(halves, reference_.half_samples, *reference_.picture);
    }
    reference_.picture->set_noise(&results_.reference);
    std::optional<std::vector<float>> motion;
    if (options_.motion) {
      motion = renderer_.render_motion(options_.frame, stop_);
      if (!motion) return false;
    }
    pictures_.write_reference(*reference_.picture, motion, &results_.reference);
    return true;
  }

  // Returns how many samples per pixel the method can take within the largest budget.
  double samples_in_largest_budget(const PlannedMethod& method) const {
    if (!plan_.by_time) return plan_.budgets.back();
    const auto pace = pace_.samples_per_s.find(method.id);
    if (pace == pace_.samples_per_s.end()) return 0;
    return pace->second * plan_.budgets.back() / double(renderer_.pixels());
  }

  uint32_t samples_for(const PlannedMethod& method, double budget) const {
    return to_samples(
        std::floor(samples_in_largest_budget(method) * budget / plan_.budgets.back()));
  }

  // Returns how many samples per pixel the pilot of a planned frame takes; 0 for other methods.
  uint32_t pilot_samples(const PlannedMethod& method, double budget) const {
    if (!method.method.planned) return 0;
    const uint32_t samples = samples_for(method, budget);
    return pilot_of(frame_options(method, samples, options_.frame.seed)).spp.value_or(0);
  }

  // Loads the runs that were finished before this study was resumed. For the methods that cannot be
  // rendered, adds failed runs.
  void find_finished_runs() {
    for (uint32_t k = 0; k < seeds_; ++k) {
      const uint32_t seed = options_.frame.seed + k;
      for (size_t m = 0; m < plan_.methods.size(); ++m) {
        const PlannedMethod& method = plan_.methods[m];
        std::optional<StudyRun> run;
        if (!method.unsupported_reason.empty()) {
          run = failed_run(method.unsupported_reason);
          run->seed = seed;
        } else if (k > 0 || pictures_.exist(method.id)) {
          run = folder_.read_run(method.id, seed);
        }
        if (!run) continue;
        run->method = m;
        results_.runs.push_back(*run);
      }
    }
  }

  // Returns false if the study was stopped.
  bool execute_runs() {
    for (uint32_t k = 0; k < seeds_; ++k) {
      const uint32_t seed = options_.frame.seed + k;
      for (const size_t m : study_order(plan_.methods.size(), seed)) {
        if (!plan_.methods[m].unsupported_reason.empty() || find_run(results_, m, seed)) continue;
        const std::optional<StudyRun> run = execute_run(m, seed);
        if (!run) return false;
        results_.runs.push_back(*run);
        log_run(*run);
      }
    }
    return true;
  }

  // Returns nothing if the study was stopped. If the run throws, returns a failed run.
  std::optional<StudyRun> execute_run(size_t m, uint32_t seed) {
    const PlannedMethod& method = plan_.methods[m];
    StudyRun run;
    try {
      const std::optional<ProgressiveFrame> frame = render_run(method, seed);
      if (!frame) return std::nullopt;
      run = measure(*frame);
      if (seed == options_.frame.seed) {
        pictures_.write(method.id, frame->pictures.back(), *reference_.picture);
      }
    } catch (const std::exception& error) {
      run = failed_run(error.what());
    }
    run.method = m;
    run.seed = seed;
    // Failed runs are not saved, so that a resumed study retries them.
    if (run.status == StudyRunStatus::kDone) folder_.write_run(method.id, run);
    return run;
  }

  // Returns nothing if the study was stopped.
  std::optional<ProgressiveFrame> render_run(const PlannedMethod& method, uint32_t seed) const {
    if (!method.separate) {
      // The number of samples of an adaptive frame must be known in advance.
      const bool ends_by_time = plan_.by_time && method.method.estimator.empty();
      const double maximum = samples_in_largest_budget(method) * (ends_by_time ? kPaceMargin : 1.0);
      ProgressiveFrame frame =
          renderer_.render_progressive(frame_options(method, to_samples(std::ceil(maximum)), seed),
                                       plan_.budgets, plan_.by_time, stop_);
      if (frame.stopped) return std::nullopt;
      return frame;
    }
    ProgressiveFrame frame;
    for (const double budget : plan_.budgets) {
      const RenderOptions options = method.has_time_budget
                                        ? deadline_options(method, budget, seed)
                                        : frame_options(method, samples_for(method, budget), seed);
      std::optional<StudyPicture> picture = renderer_.render(options, aovs_of(options), stop_);
      if (!picture) return std::nullopt;
      if (method.method.denoised) denoise_picture(renderer_.crop(), &*picture);
      picture->budget = budget;
      frame.non_finite_samples += picture->non_finite_samples;
      if (picture->estimate) {
        frame.estimates.push_back(
            {picture->samples, *picture->estimate,
             to_rgb_image(picture->values, kStudyPictureChannels, renderer_.crop())});
      }
      frame.pictures.push_back(std::move(*picture));
    }
    return frame;
  }

  StudyRun measure(const ProgressiveFrame& frame) const {
    const auto pixels = double(renderer_.pixels());
    StudyRun run;
    run.non_finite_samples = frame.non_finite_samples;
    for (const StudyPicture& picture : frame.pictures) {
      run.checkpoints.push_back(picture);
      run.checkpoints.back().error = reference_.picture->measure(
          to_rgb_image(picture.values, kStudyPictureChannels, renderer_.crop()));
    }
    for (const RoundEstimate& claim : frame.estimates) {
      const double square = reference_.picture->measure(claim.picture).display_mse;
      run.calibration.push_back(
          {double(claim.samples) / pixels, claim.estimate, square > 0 ? std::sqrt(square) : NAN});
    }
    return run;
  }

  void log_run(const StudyRun& run) const {
    const std::string what = fmt::format("{} of {} runs: {}, seed {}", results_.runs.size(),
                                         size_t(seeds_) * plan_.methods.size(),
                                         results_.methods[run.method].name, run.seed);
    if (run.status == StudyRunStatus::kFailed) {
      log_warning(what + " failed: " + run.reason);
      return;
    }
    const StudyCheckpoint& last = run.checkpoints.back();
    log_info(fmt::format("{}: {:.4g} samples per pixel in {:.3g} s, mse {:.4g}", what,
                         last.mean_samples, last.wall_s, last.error.mse));
  }

  const StudyOptions& options_;
  const StudyPlan& plan_;
  const uint32_t seeds_;
  const LoadLimits limits_;
  std::optional<RgbImage> given_reference_;
  StudyFolder folder_;
  StudyRenderer renderer_;
  StudyPictures pictures_;
  std::string frame_key_;
  MemoryReservation memory_;  // for the largest frame and the references
  StudyPace pace_;
  Reference reference_;
  StudyResults results_;
  std::stop_token stop_;
};

}  // namespace

StudyOutcome execute_study(const StudyOptions& options, const std::string& folder,
                           const StudyClient& client) {
  const StudyPlan plan = plan_study(options);
  FileRegister files;
  files.write_below(folder, options.folder);
  register_inputs(options.frame, files);
  if (!options.reference.empty()) {
    files.read(options.reference, "it contains the file of `reference`");
  }
  return tbb::task_arena(options.frame.threads).execute([&] {
    Study study(options, plan, files, options.frame.threads);
    study.prepare();
    client(study.remaining_samples(), [&](const auto& on_samples, std::stop_token stop) {
      study.render(on_samples, std::move(stop));
    });
    StudyOutcome outcome;
    if (!study.has_reference()) return outcome;
    study.write_results(outcome.attempts);
    outcome.results = study.results();
    return outcome;
  });
}

}  // namespace emberline
