// A frame driver decides which pixel gets its next samples. It is no more than these decisions, as
// data: RenderJob (renderer/engine) carries them out, pauses, and tells the sink. Drivers are
// interchangeable: for equal sample counts they produce equal bits (law 2), because every sample is
// a pure function of the frame (law 1) and each pixel's samples are added in index order by one
// owner.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "renderer/film/pixel_stop.h"

namespace emberline {

class Archive;
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

// What is rendered before the driver decides again: parts of about a millisecond of work, begun in
// order and carried out side by side. No pixel is in two of them.
struct Round {
  size_t parts = 0;
  uint32_t seed = 0;       // of its samples
  int pass = 0;            // the first brings every pixel its first sample
  bool ends_pass = false;  // with the last part
  bool operator==(const Round&) const = default;
};

// The parts [begin, end) of a round.
struct RenderedParts {
  size_t begin = 0, end = 0;
  bool complete = true;  // false: a stop request came before all was done; the parts after `end`
                         // have not begun, and of those before only these may lack samples
  std::span<const size_t> cut_short = {};
};

// What some drivers know of a frame beside its film, at a pause or after the last round.
struct DriverFacts {
  // By which the first samples were placed, if DriverSettings::keep_tree asked for it.
  const RefinementTree* tree = nullptr;
  // Of an incomplete frame: the finest lattice whose pixels all have samples.
  const PixelLattice* lattice = nullptr;
};

// Of one film: the crop's, or a tile's. Of each round that next() gives, rendered() is told all
// parts, once or part by part, before next() is called again. No call while samples are added, but
// expand().
class FrameDriver {
 public:
  virtual ~FrameDriver() = default;

  // Decides from the film, which has all samples of the rounds before, and writes into it what it
  // knows of the samples' variances. Nothing: the frame is finished, or a stop was requested
  // meanwhile.
  virtual std::optional<Round> next(FilmTile& film, const std::stop_token& stop) = 0;
  // The round under way, as next() gave it; of no parts before the first.
  virtual Round round() const = 0;
  // Writes a part of the round into an empty list. From worker threads, concurrently.
  virtual void expand(size_t part, std::vector<PixelWork>& list) const = 0;
  // How many samples that brings.
  virtual uint64_t samples(size_t part) const = 0;
  // These parts of the round are in the film.
  virtual void rendered(const RenderedParts& parts, const FilmTile& film) = 0;

  // Every sample is in the film that the driver will ask for.
  virtual bool finished() const = 0;
  // The least of any pixel.
  virtual uint32_t least_samples(const FilmTile& film) const = 0;
  // Expected RMS error of the displayed picture as of the last decision, if that is known.
  virtual std::optional<double> error_estimate() const { return std::nullopt; }
  // Why the pixel gets no more samples, as far as that is decided by now; kGoingOn for the others.
  virtual PixelStop stop_so_far(const FilmTile& film, int x, int y) const = 0;
  // LivePicture::resolve: what the film has, unless the driver knows better.
  virtual void resolve(const FilmTile& film, std::span<float> rgba, const LightMix* mix) const;
  // resolve() has something else to show than the film's means, also where that has samples.
  virtual bool shows_other_means() const { return false; }
  virtual DriverFacts facts() const { return {}; }
  // What decided the number of the pixel's samples, in lines for people, or what does so far; at a
  // pause, or in the end. Empty: nothing is decided by pixel.
  virtual std::string explain(const FilmTile& /*film*/, int /*x*/, int /*y*/) const { return {}; }
  // At a pause: explain() will be asked about this pixel instead of the settings', and has to tell
  // of it what happens from here on.
  virtual void follow(int /*x*/, int /*y*/) {}
  // After the last round: writes into the film why each pixel stopped, those that a stop request
  // cut short because of `cut_short`, and what else looks at every pixel once more.
  virtual void end(FilmTile& film, PixelStop cut_short) = 0;

  // The state between two parts, whose samples the film has, and rendered() was told of all: a new
  // driver of the same frame, settings and pixels goes on from there to the same bits. Which parts
  // of round() those were its caller knows. Throws InputError while it loads.
  virtual void archive(Archive& archive, const FilmTile& film) = 0;
  // Of a new driver, with larger settings than those of a frame that is finished: loads that
  // frame's state, and goes on from its film. A driver that asks for samples by their number alone
  // begins at the first, of which its caller leaves out what the film has.
  virtual void extend(Archive& /*finished*/, const FilmTile& /*film*/) {}

  // Held beside the film.
  virtual uint64_t bytes() const { return 0; }
};

}  // namespace emberline
