// Takes snapshots of a progressive render: pictures at given moments, an animation of these
// pictures, and their errors against a reference.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/display/display.h"
#include "io/files/owned_folder.h"
#include "io/files/write_attempts.h"
#include "renderer/core/names.h"
#include "renderer/core/rect.h"
#include "renderer/engine/render_sink.h"
#include "renderer/output/render_options.h"
#include "renderer/statistics/error_metrics.h"

namespace emberline {

// A moment is due at the driver's first pause after its value is reached. The driver pauses for it
// as soon as the parts in progress are finished (render_sink.h).
struct SnapshotMoment {
  enum class Unit : uint8_t { kFirstPause, kPercentCovered, kSeconds, kSamplesPerPixel };
  Unit unit = Unit::kFirstPause;
  double value = 0.0;
  bool operator==(const SnapshotMoment&) const = default;
};

inline constexpr std::string_view kDefaultSnapshotMoments =
    "first,1%,2%,5%,10%,25%,35%,50%,75%,100%";

// Parses a list such as "first,2.5%,0.5s,4spp". Throws a UsageError that names --snapshot-at.
std::vector<SnapshotMoment> parse_snapshot_moments(std::string_view list);

enum class SnapshotFormat { kPng, kExr };
std::span<const NamedValue<SnapshotFormat>> snapshot_format_table();

// Whether a recorder may write a file of this name, such as "003_0010pct.png" or "refinement.gif".
bool is_snapshot_name(const std::string& name);

struct SnapshotReport {
  std::string file;         // in the folder of --snapshots; empty: could not be written
  double completion = 0.0;  // fraction of the first pass, in [0, 1]
  uint64_t samples = 0;     // number of samples in the frame so far
  double elapsed_s = 0.0;   // render time, excluding earlier snapshots
  // Error against the reference, if there is one. rmse is computed from display values (sRGB, 0 to
  // 1, after --exposure). mse and rel_mse are computed from radiance. See error_metrics.h.
  std::optional<double> rmse, mse, rel_mse;
};

class SnapshotRecorder {
 public:
  // Checks all options. Creates the folder if it does not exist; the destructor removes it again if
  // it is still empty. Throws UsageError, for example if a file of another program has the name of
  // a snapshot. Throws RenderError for an unwritable folder, and InputError for a reference that
  // cannot be read or does not cover the crop.
  SnapshotRecorder(const RenderOptions& options, const Rect& crop, const LoadProgress& progress);

  // Copies the picture if a snapshot is due. `elapsed_s` is the render time so far.
  void update(const JobProgress& progress, const LivePicture& picture, double elapsed_s);

  // For RenderSink. is_due() returns whether a snapshot with a moment in seconds is due.
  // next_sample_count() returns the frame's sample count at which the next snapshot with another
  // kind of moment is due. Any thread may call these functions, but not during update().
  bool is_due(double elapsed_s) const;
  std::optional<uint64_t> next_sample_count() const;

  // Encodes, writes and measures the copies.
  std::vector<SnapshotReport> write(WriteAttempts& attempts);

 private:
  struct Snapshot {
    SnapshotMoment moment;
    JobProgress progress;
    double elapsed_s;
    std::shared_ptr<const std::vector<float>> rgba;  // shared by snapshots of the same pause
  };

  bool is_reached(const SnapshotMoment& moment, const JobProgress& progress,
                  double elapsed_s) const;
  bool matches_pending(const std::string& name) const;
  void write_exr(const std::string& file, const std::vector<float>& rgba) const;
  void write_animation() const;

  RenderOptions options_;
  Rect crop_;
  SnapshotFormat format_;
  std::vector<SnapshotMoment> pending_;
  std::vector<Snapshot> recorded_;
  std::shared_ptr<const DisplayTransform> transform_;
  std::optional<RgbImage> reference_;
  std::optional<OwnedFolder> folder_;
};

}  // namespace emberline
