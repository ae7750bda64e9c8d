// Speed against error of several ways to render one frame: from warm-up to results.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "io/files/write_attempts.h"
#include "renderer/statistics/study/folder.h"
#include "renderer/statistics/study/pictures.h"
#include "renderer/statistics/study/plan.h"
#include "renderer/statistics/study/reference.h"
#include "renderer/statistics/study/renderer.h"

namespace emberline {

// In this order: prepare(), render(), and with a reference write_results(); on one thread and in
// its TBB arena.
class Study {
 public:
  // Loads the scene, opens the folder. Throws UsageError, InputError, RenderError for whatever is
  // wrong with the options; `threads` is for the records. Refers to all but that.
  Study(const StudyOptions& options, const StudyPlan& plan, FileRegister& files, int threads);

  // Warms up, which tells each method's pace, and looks for what an earlier start has finished.
  void prepare();
  // How many render() will take; of runs that end by time a guess.
  uint64_t samples_to_come() const;
  // The reference, then the runs. `on_samples` is called from any thread. A run that fails is kept
  // as failed; what a stop cuts short is left for the next start.
  void render(const std::function<void(uint64_t)>& on_samples, std::stop_token stop);
  // False if the stop came first: then there are no results.
  bool has_reference() const { return reference_.picture.has_value(); }
  // study.csv, study.json and study.html.
  void write_results(WriteAttempts& attempts);
  const StudyResults& results() const { return results_; }

 private:
  struct Reference {
    std::optional<ReferencePicture> picture;
    std::array<std::optional<ReferenceHalf>, 2> halves;
    std::array<ReferenceRequest, 2> requests;
    uint32_t half_samples = 0;
  };

  void reserve_frames();
  std::vector<std::string> file_names() const;
  void describe_settings(int threads);
  void prepare_pace();
  double warm_up(const PlannedMethod& method) const;
  uint32_t reference_samples() const;
  void find_reference();
  bool complete_reference();
  double largest_budget(const PlannedMethod& method) const;
  uint32_t samples_for(const PlannedMethod& method, double budget) const;
  void find_finished_runs();
  bool make_runs();
  std::optional<StudyRun> make_run(size_t method, uint32_t seed);
  std::optional<ProgressiveFrame> render_run(const PlannedMethod& method, uint32_t seed) const;
  StudyRun measure(const ProgressiveFrame& frame) const;
  void log_run(const StudyRun& run) const;

  const StudyOptions& options_;
  const StudyPlan& plan_;
  const uint32_t seeds_;
  const LoadLimits limits_;
  std::optional<RgbImage> given_reference_;
  StudyFolder folder_;
  StudyRenderer renderer_;
  StudyPictures pictures_;
  std::string frame_key_;
  MemoryReservation memory_;  // of the largest frame and the references
  StudyPace pace_;
  Reference reference_;
  StudyResults results_;
  std::stop_token stop_;
};

// What a study has come to.
struct StudyOutcome {
  std::optional<StudyResults> results;  // none: stopped before there was a reference
  WriteAttempts attempts = {};
};
// A study from its options to its files, on `options.frame.threads` threads. `folder`: what the
// client calls the folder of the results. `render` calls Study::render(), once. Throws UsageError,
// InputError and RenderError.
StudyOutcome make_study(const StudyOptions& options, const std::string& folder,
                        const std::function<void(Study&)>& render);

}  // namespace emberline
