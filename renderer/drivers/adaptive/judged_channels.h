// The channels whose errors decide how many samples a pixel gets (setting `judge`), and the
// estimate of these errors.
//
// The picture's R G B have their own estimator (error_estimator.h). For every other channel, the
// pixel's samples are divided into two parts (sample_halves.h). The difference between the means of
// the parts gives the variance, which is pooled over neighbours (pooling.h). `nested` does the same
// for R G B. How a variance becomes an error is a property of the channel (ErrorScale).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/drivers/adaptive/adaptive_settings.h"
#include "renderer/drivers/adaptive/sample_halves.h"

namespace emberline {

class Archive;
struct ChannelRow;
struct ErrorMap;
class FilmTile;
struct PixelStatistics;

// Parses a list such as "RGB,A:0.005". Throws a UsageError with the valid names.
std::vector<JudgedChannel> parse_judged(std::string_view list);
// Returns a list that parse_judged() accepts.
std::string judged_list(std::span<const JudgedChannel> channels);
// Returns the bytes per pixel that the channels take in addition to R G B, in a film with this
// number of light groups.
uint64_t judged_bytes_per_pixel(std::span<const JudgedChannel> channels, int light_groups);

// Judges the pixels of one film by several channels. Errors of a channel are multiplied by the
// frame's threshold over the channel's threshold, so that they can be compared with the frame's
// threshold. A pixel's error is the largest of its channels' scaled errors. Its squared deviation
// is the sum of their squared deviations, with the same scales.
class JudgedChannels {
 public:
  // An empty list means R G B. `threshold` is the frame's threshold; 0: none.
  JudgedChannels(std::vector<JudgedChannel> channels, float threshold, int light_groups);

  size_t size() const { return channels_.size(); }
  const JudgedChannel& operator[](size_t channel) const { return channels_[channel]; }
  float threshold(size_t channel) const;  // 0: none
  // Returns whether only R G B are judged, and by the frame's threshold. update() is then not
  // needed.
  bool is_default() const {
    return values_.empty() && judges_picture_ && relative_scale(picture_) == 1.0f;
  }

  // value_count() is the number of judged values of a pixel, without R G B. read_means() writes the
  // mean of each of these values over the pixel's samples, or kNoMean if no sample has the value.
  size_t value_count() const { return value_count_; }
  void read_means(const FilmTile& film, size_t i, float* means) const;

  // Expects the errors of R G B in `errors` and replaces them by the combined errors of all judged
  // channels. `halves` must have been updated with read_means(). Results are finite and not
  // negative.
  void update(const FilmTile& film, const PixelStatistics& pixels, const SampleHalves& halves,
              ErrorMap* errors);
  // From now on, update() stores each channel's error in this pixel for recorded_errors().
  void record(size_t pixel) {
    if (pixel != recorded_) recorded_errors_.clear();
    recorded_ = pixel;
  }
  // The recorded pixel's errors, one per channel, in the channel's own scale. Empty before the
  // first update.
  std::span<const float> recorded_errors() const { return recorded_errors_; }
  // The index of the channel whose recorded error is the largest in relation to its threshold.
  uint32_t recorded_channel() const { return recorded_channel_; }

  // Returns the index of the channel that last kept the pixel unfinished: the one furthest above
  // its threshold in the last update that found any error above its threshold. Without thresholds,
  // this is the channel with the largest error.
  uint32_t last_unfinished(size_t i) const { return i < last_.size() ? last_[i] : picture_; }

  void archive(Archive& archive, size_t pixels);
  uint64_t bytes() const { return last_.capacity(); }
  // The most bytes per pixel that update() needs in addition to judged_bytes_per_pixel().
  static constexpr uint64_t kUpdateBytes = 5 * sizeof(float) + 2;

 private:
  static constexpr float kNoMean = 3e38f;
  // Values that are measured together: those of a channel, or those of one light group.
  struct Values {
    uint8_t channel;
    const ChannelRow* row;
    int light_group;      // -1: the row's own values
    size_t first, count;  // a range of the values that read_means() writes
    size_t skipped;       // position of the first of these values in the row
  };
  void add_values(uint8_t channel, int light_groups);
  void read_values(const FilmTile& film, const Values& values, size_t i, float* out) const;
  void measure(const FilmTile& film, const PixelStatistics& pixels, const SampleHalves& halves,
               const Values& values, std::vector<float>* variances) const;
  void add_errors(const Values& values, const PixelStatistics& pixels,
                  std::span<const float> variances, std::span<uint8_t> furthest, ErrorMap* errors);
  float relative_scale(size_t channel) const;
  void scale_picture(ErrorMap* errors);

  std::vector<JudgedChannel> channels_;
  float threshold_;
  bool judges_picture_ = false;
  uint8_t picture_ = 0;  // index of R G B
  std::vector<Values> values_;
  size_t value_count_ = 0;
  std::vector<uint8_t> last_;
  size_t recorded_ = SIZE_MAX;
  std::vector<float> recorded_errors_;
  uint32_t recorded_channel_ = 0;
};

}  // namespace emberline
