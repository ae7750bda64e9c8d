// `adaptive`: samples go where the error is, round by round (after Painter & Sloan 1989,
// "Antialiased Ray Tracing by Adaptive Progressive Refinement", with today's estimators beside
// theirs).
//
// First one sample for every pixel, in the order of the refinement tree; then the estimator's
// pilot; then rounds: at each barrier the planner decides from the film how many samples every
// pixel gets next. If the picture is not shown before it is finished, it begins with the pilot.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/drivers/adaptive/refinement_tree.h"
#include "renderer/drivers/adaptive/round_averages.h"
#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

// The pixels of a crop in the order in which a round visits them: tiles of 16 x 16 pixels row by
// row, and within a tile row by row, so that neighbours in the list are neighbours in the frame. By
// index, rows from the crop's top.
std::vector<uint32_t> tile_order(const Rect& crop);

// Cuts a round's list of pixels into parts of about `samples` samples (at least one pixel each):
// entry p is part p's first place in the list, the last entry the list's length. Pixel order[k] is
// to go from have[order[k]] to targets[order[k]] samples.
std::vector<size_t> cut_into_parts(std::span<const uint32_t> order, std::span<const uint32_t> have,
                                   std::span<const uint32_t> targets, uint64_t samples);

// Sorts the parts by the expected gain of their samples, so that a picture shown or stopped in the
// middle of a round has improved where it was worst. gain[i] is the squared error that the
// samples of pixel i in this round take away; a part's rank is the sum over its pixels by its
// samples. Equal parts come in van der Corput's order, spread over the frame.
std::vector<uint32_t> parts_by_gain(std::span<const size_t> parts, std::span<const uint32_t> order,
                                    std::span<const uint32_t> have,
                                    std::span<const uint32_t> targets, std::span<const float> gain);

// Whether the frame is shown before it is finished: then it is complete from the first samples on,
// and can be shown at any moment.
enum class FirstPicture { kNotShown, kShown };

class AdaptiveDriver final : public FrameDriver {
 public:
  // Throws UsageError for an unknown estimator.
  AdaptiveDriver(const Frame& frame, const Rect& crop, const DriverSettings& settings,
                 FirstPicture first_picture);

  std::optional<Round> next(FilmTile& film, const std::stop_token& stop) override;
  Round round() const override;
  void expand(size_t part, std::vector<PixelWork>& list) const override;
  uint64_t samples(size_t part) const override;
  void rendered(const RenderedParts& parts, const FilmTile& film) override;
  bool finished() const override { return stage_ == Stage::kFinished; }
  uint32_t least_samples(const FilmTile& film) const override;
  std::optional<double> error_estimate() const override;
  PixelStop stop_so_far(const FilmTile& film, int x, int y) const override;
  void resolve(const FilmTile& film, std::span<float> rgba, const LightMix* mix) const override;
  bool shows_other_means() const override { return !averages_.empty(); }
  void end(FilmTile& film, PixelStop cut_short) override;
  void archive(Archive& archive, const FilmTile& film) override;
  void extend(Archive& finished, const FilmTile& film) override;
  uint64_t bytes() const override;

  DriverFacts facts() const override;
  std::string explain(const FilmTile& film, int x, int y) const override;
  void follow(int x, int y) override;

  static FilmExtras film_extras(const AdaptiveSettings& settings);
  // The most that bytes() reaches, per pixel.
  static uint64_t bytes_per_pixel(const AdaptiveSettings& settings);

 private:
  enum class Stage {
    kTree,       // first samples where the refinement tree asks for them
    kFirst,      // a first sample for the others
    kPilotStep,  // else, for as long as the pilot takes, pixels with all of it would stand beside
                 // pixels with one sample, which looks like dirt on the picture
    kPilot,
    kRounds,
    kFinished,
  };

  size_t index(int x, int y) const { return crop_.index_of(x, y); }
  int x_of(size_t i) const { return crop_.x_of(i); }
  int y_of(size_t i) const { return crop_.y_of(i); }
  // Every pixel has a sample.
  bool covered() const { return stage_ > Stage::kFirst; }

  std::optional<Round> next_of_tree();
  size_t refined_pixels() const;
  void archive_tree(Archive& archive);
  Round bring_to(std::span<const uint32_t> targets, bool ends_pass);
  Round bring_all_to(uint32_t samples, bool ends_pass);
  size_t turn(size_t part) const { return shown_ ? turns_[part] : part; }
  PixelStop stop_of(size_t i, PixelStop cut_short) const;
  std::string fate_of(size_t i) const;
  void fill_from_tree(const FilmTile& film, std::span<float> rgba) const;

  const Rect crop_;
  const DriverSettings settings_;
  const bool shown_, smooth_;
  RoundPlanner planner_;
  RoundAverages averages_;
  std::optional<RefinementTree> tree_;  // until every pixel has a sample, or kept
  std::vector<uint32_t> order_;
  std::vector<uint32_t> have_;  // samples of each pixel
  Stage stage_;
  int pass_ = 1;
  bool ends_pass_ = false;  // the round under way does
  bool averaged_ = false;   // the averages have the last round
  // The round under way: of the tree, these pixels; else the samples that each pixel is to have,
  // the parts' places in order_, and their turns.
  std::span<const Vec2i> wanted_;
  std::span<const uint32_t> targets_;
  std::vector<uint32_t> even_;  // targets that are the same for all
  std::vector<size_t> parts_;
  std::vector<uint32_t> turns_;
  std::vector<float> gains_;
  std::optional<PixelStop> ended_;  // end() was called, with this
  int followed_from_ = 0;  // the round in which the recorded pixel was asked for; 0: before all
};

}  // namespace emberline
