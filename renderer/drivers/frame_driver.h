// A frame driver decides which pixels get the next samples, and returns its decisions as data.
// RenderJob (renderer/engine) renders them, pauses and calls the sink. Drivers are interchangeable:
// pixels with equal sample counts are bit-identical (law 2), because every sample is a pure
// function of the frame (law 1) and each pixel's samples are added in index order by one owner.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "renderer/drivers/work_forecast.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {

class Archive;
struct AdaptiveSettings;
class FilmTile;
class LightMix;
struct PixelLattice;
class RefinementTree;

// Samples [first_sample, first_sample + sample_count) of a pixel.
struct PixelWork {
  int x = 0, y = 0;
  uint32_t first_sample = 0;
  uint32_t sample_count = 0;
  bool operator==(const PixelWork&) const = default;
};

// The work until the driver decides again. It consists of parts of about a millisecond each. Parts
// are started in order and rendered in parallel. No pixel is in two parts.
struct Round {
  size_t parts = 0;
  uint32_t seed = 0;       // seed of the round's samples
  int pass = 0;            // in pass 1 every pixel gets its first sample
  bool ends_pass = false;  // true if the last part completes the pass
  bool operator==(const Round&) const = default;
};

// Parts [begin, end) of a round.
struct RenderedParts {
  size_t begin = 0, end = 0;
  bool complete = true;  // false: a stop request ended the round. Parts from `end` on were not
                         // started. Of the parts before `end`, only those in `interrupted` may
                         // lack samples.
  std::span<const size_t> interrupted = {};
};

// Additional data that some drivers provide, valid at a pause or after the last round.
struct DriverFacts {
  // The tree that placed the first samples, if DriverSettings::keep_tree is set.
  const RefinementTree* tree = nullptr;
  // For an incomplete frame, the finest lattice whose pixels all have samples.
  const PixelLattice* lattice = nullptr;
};

// Drives the film of the whole crop or of one tile. Between two calls of next(), the caller must
// call rendered() for all parts of the round, in one or more calls. While samples are added, only
// expand() may be called.
class FrameDriver {
 public:
  virtual ~FrameDriver() = default;

  // Decides the next round from the film, which must have all samples of earlier rounds. Writes
  // estimates of the samples' variances into the film. Returns nothing if the frame is finished, or
  // if a stop was requested during the call.
  virtual std::optional<Round> next(FilmTile& film, const std::stop_token& stop) = 0;
  // The current round, as next() returned it. Before the first round, it has no parts.
  virtual Round round() const = 0;
  // Appends a part's work to `list`. Worker threads call this concurrently.
  virtual void expand(size_t part, std::vector<PixelWork>& list) const = 0;
  virtual uint64_t samples(size_t part) const = 0;
  // Tells the driver that the film has the samples of these parts.
  virtual void rendered(const RenderedParts& parts, const FilmTile& film) = 0;

  // Returns whether the film has all samples that the driver will request.
  virtual bool finished() const = 0;
  // For frames with a time budget: requests more samples, so that the work of the whole frame is
  // about `factor` times the work so far. Call when finished(), at a pause.
  virtual void extend_work(double /*factor*/) {}
  // Returns the smallest number of samples of any pixel.
  virtual uint32_t min_samples(const FilmTile& film) const = 0;
  // Returns the expected RMS error of the displayed picture as of the last decision, if known.
  virtual std::optional<double> error_estimate() const { return std::nullopt; }
  // Predicts the work of the whole frame. Call at the end of a pass. Returns nullopt if the driver
  // cannot tell. May take as long as next().
  virtual std::optional<WorkForecast> forecast() const { return std::nullopt; }
  // Returns why the pixel gets no more samples, or kUnfinished if that is not decided yet.
  virtual PixelStop current_stop(const FilmTile& film, int x, int y) const = 0;
  // Implements LivePicture::resolve(). The default shows the film. Drivers that fill in pixels
  // override it.
  virtual void resolve(const FilmTile& film, std::span<float> rgba, const LightMix* mix) const;
  // Returns whether resolve() may show a sampled pixel with a value other than its mean in the
  // film.
  virtual bool overrides_means() const { return false; }
  virtual DriverFacts facts() const { return {}; }
  // Returns a sentence on why the recorded pixel got its samples, or an empty text if no pixel is
  // recorded. Must be called at a pause or after the last round.
  virtual std::string history() const { return ""; }
  // Returns a text for the user that explains the pixel's number of samples so far. The text is
  // empty if the driver does not decide about single pixels. Must be called at a pause or at the
  // end.
  virtual std::string explain(const FilmTile& /*film*/, int /*x*/, int /*y*/) const { return {}; }
  // Returns the sample counts that a frame with these limits should have, according to the samples
  // taken so far, for each pixel in rows from the top. Call after end(). Returns an empty list if
  // the driver does not estimate deviations, or has not done so yet.
  virtual std::vector<uint32_t> planned_counts(const AdaptiveSettings& /*limits*/) const {
    return {};
  }
  // From now on, records this pixel for explain(), instead of DriverSettings::explained. Must be
  // called at a pause.
  virtual void record_pixel(int /*x*/, int /*y*/) {}
  // Must be called after the last round. Writes each pixel's stop reason into the film
  // (`interrupted` for pixels that a stop request ended), and does all other final work that visits
  // every pixel.
  virtual void end(FilmTile& film, PixelStop interrupted) = 0;

  // Saves or loads the state between two parts; rendered() must have been called for all samples in
  // the film. A new driver with the same frame, settings and pixels can load the state and
  // continue, with a bit-identical result. The caller must store which parts of round() are done.
  // Loading throws InputError for an invalid state.
  virtual void archive(Archive& archive, const FilmTile& film) = 0;
  // Makes this new driver continue a finished frame: loads the frame's state and continues from the
  // frame's film. The driver's settings must extend those of the frame. Drivers whose requests do
  // not depend on the film start again at the first sample; the caller skips samples that the film
  // already has.
  virtual void extend(Archive& /*finished*/, const FilmTile& /*film*/) {}

  // Returns the bytes that the driver uses, without the film.
  virtual uint64_t bytes() const { return 0; }
};

}  // namespace emberline
