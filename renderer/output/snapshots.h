// What a progressive render showed on its way: pictures at given moments, an animation of them, and
// how far each was from a reference.
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

// When a snapshot is due: at the driver's first pause at which this much has been reached, which it
// makes for it with the next part of its work.
struct SnapshotMoment {
  enum class Unit : uint8_t { kFirstPause, kPercentCovered, kSeconds, kSamplesPerPixel };
  Unit unit = Unit::kFirstPause;
  double value = 0.0;
  bool operator==(const SnapshotMoment&) const = default;
};

inline constexpr std::string_view kDefaultSnapshotMoments =
    "first,1%,2%,5%,10%,25%,35%,50%,75%,100%";

// "first,2.5%,0.5s,4spp". Throws UsageError naming --snapshot-at.
std::vector<SnapshotMoment> parse_snapshot_moments(std::string_view list);

enum class SnapshotFormat { kPng, kExr };
std::span<const NamedValue<SnapshotFormat>> snapshot_format_table();

// A file that a recorder may write into its folder: "003_0010pct.png", "refinement.gif".
bool is_snapshot_name(const std::string& name);

struct SnapshotReport {
  std::string file;         // in the folder of --snapshots; empty: it could not be written
  double completion = 0.0;  // of the first pass, in [0, 1]
  uint64_t samples = 0;     // of the frame, so far
  double elapsed_s = 0.0;   // of rendering, without what earlier snapshots took
  // Against the reference, if there is one: of display values (sRGB, 0 to 1, after --exposure), and
  // of radiance as error_metrics.h has it.
  std::optional<double> rmse, mse, rel_mse;
};

class SnapshotRecorder {
 public:
  // Everything that can be wrong with the options is found here. Makes the folder if it does not
  // exist; one that it made and left empty is removed in the end. Throws UsageError, also for a
  // folder with a file of someone else under a name that a snapshot may get, RenderError for a
  // folder that cannot be written to, InputError for a reference that cannot be read or has another
  // size than the crop.
  SnapshotRecorder(const RenderOptions& options, const Rect& crop, const LoadProgress& progress);

  // Copies the picture if a snapshot is due, `elapsed_s` into the rendering.
  void look(const JobProgress& progress, const LivePicture& picture, double elapsed_s);

  // What RenderSink asks, on any thread while look() is not called: whether a moment has come,
  // and the number of samples of the next one that goes by samples.
  bool wanted(double elapsed_s) const;
  std::optional<uint64_t> wanted_at() const;

  // Encodes, writes and measures what was copied.
  std::vector<SnapshotReport> write(WriteAttempts& attempts);

 private:
  struct Snapshot {
    SnapshotMoment moment;
    JobProgress progress;
    double elapsed_s;
    std::shared_ptr<const std::vector<float>> rgba;  // shared by those due at one pause
  };

  bool due(const SnapshotMoment& moment, const JobProgress& progress, double elapsed_s) const;
  bool may_write(const std::string& name) const;
  void write_exr(const std::string& file, const std::vector<float>& rgba) const;
  void write_animation() const;

  RenderOptions options_;
  Rect crop_;
  SnapshotFormat format_;
  std::vector<SnapshotMoment> waiting_;
  std::vector<Snapshot> taken_;
  std::shared_ptr<const DisplayTransform> transform_;
  std::optional<RgbImage> reference_;
  std::optional<OwnedFolder> folder_;
};

}  // namespace emberline
