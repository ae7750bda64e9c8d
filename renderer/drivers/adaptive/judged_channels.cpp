#include "renderer/drivers/adaptive/judged_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "renderer/core/archive.h"
#include "renderer/core/display_error.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/core/parallel.h"
#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/adaptive/pixel_errors.h"
#include "renderer/drivers/adaptive/pixel_statistics.h"
#include "renderer/drivers/adaptive/pooling.h"
#include "renderer/film/channels.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

constexpr std::string_view kPicture = "RGB", kAlpha = "A", kLights = "light.*";
constexpr size_t kMaxValues = 4;  // of a channel row
constexpr float kMinThreshold = 1e-6f, kMaxThreshold = 1e6f;
constexpr float kMaxVariance = 1e18f;
constexpr size_t kGrain = 4096;

const ChannelRow* find_row(std::string_view name) {
  if (name == kAlpha) return &row_of(Aov::kPicture);
  const std::string_view row_name = name == kLights ? name.substr(0, name.find('.')) : name;
  const auto row = std::ranges::find(channel_table(), row_name, &ChannelRow::name);
  return row != channel_table().end() ? &*row : nullptr;
}

// Returns the factor that converts a squared error of the channel's value to the channel's error
// scale, in which it is compared with the threshold.
float error_weight(ErrorScale scale, float mean, float deviation) {
  switch (scale) {
    case ErrorScale::kDisplay:
      return display_error_weight(mean, deviation);
    case ErrorScale::kRelative:
      return 1.0f / std::max(mean * mean, 1e-30f);
    default:
      return 1.0f;
  }
}

ErrorScale scale_of(const ChannelRow& row, std::string_view name) {
  return name == kAlpha ? ErrorScale::kAbsolute : row.error;
}

// Returns the names that parse_judged() accepts.
std::vector<std::string_view> valid_names() {
  std::vector<std::string_view> names = {kPicture, kAlpha, kLights};
  for (const ChannelRow& row : channel_table()) {
    if (row.error != ErrorScale::kNone && row.setting == "aov") names.push_back(row.name);
  }
  return names;
}

// Pools `in`, a plane of width x height values, into `out` (pooling.h). `across` is a buffer.
void pool_plane(std::span<const float> in, size_t width, size_t height, std::vector<float>* across,
                std::vector<float>* out) {
  constexpr size_t kRows = 16;
  across->resize(in.size());
  out->resize(in.size());
  parallel_ranges(height, kRows, [&](size_t begin, size_t end) {
    std::vector<float> padded(width + 2 * kPoolRadius);
    for (size_t y = begin; y < end; ++y) {
      std::copy_n(&in[y * width], width, padded.data() + kPoolRadius);
      pool_across(padded.data() + kPoolRadius, int(width), across->data() + y * width);
    }
  });
  const std::vector<float> outside(width);
  parallel_ranges(height, kRows, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      std::array<const float*, 2 * kPoolRadius + 1> rows;
      for (size_t k = 0; k < rows.size(); ++k) {
        const size_t from = y + k - kPoolRadius;  // negative rows wrap to large numbers
        rows[k] = from < height ? across->data() + from * width : outside.data();
      }
      pool_down(rows, int(width), out->data() + y * width);
    }
  });
}

}  // namespace

std::vector<JudgedChannel> parse_judged(std::string_view list) {
  constexpr std::string_view kSetting = "`judge`";
  const std::vector<std::string_view> valid = valid_names();
  std::vector<JudgedChannel> channels;
  for (const std::string_view entry : split_list(list)) {
    const size_t colon = entry.find(':');
    const std::string_view name = entry.substr(0, colon);
    if (std::ranges::find(valid, name) == valid.end()) {
      throw_unknown_name(kSetting, "channel", name, valid);
    }
    if (std::ranges::find(channels, name, &JudgedChannel::name) != channels.end()) {
      throw UsageError("{}: {} is in the list twice", kSetting, name);
    }
    JudgedChannel channel{std::string(name)};
    if (colon != std::string_view::npos) {
      const std::optional<float> threshold = parse_share(entry.substr(colon + 1));
      if (!threshold || *threshold < kMinThreshold || *threshold > kMaxThreshold) {
        throw UsageError("{}: the threshold of {} must be a number from {} to {}", kSetting, name,
                         kMinThreshold, kMaxThreshold);
      }
      channel.threshold = *threshold;
    }
    channels.push_back(std::move(channel));
  }
  if (channels.empty()) throw UsageError("{}: the list is empty", kSetting);
  return channels;
}

std::string judged_list(std::span<const JudgedChannel> channels) {
  std::string list;
  for (const JudgedChannel& channel : channels) {
    if (!list.empty()) list += ',';
    list += channel.name;
    if (channel.threshold > 0.0f) list += fmt::format(":{}", channel.threshold);
  }
  return list;
}

uint64_t judged_bytes_per_pixel(std::span<const JudgedChannel> channels, int light_groups) {
  uint64_t values = 0;
  for (const JudgedChannel& channel : channels) {
    if (channel.name == kPicture) continue;
    if (channel.name == kLights) {
      values += 3 * size_t(std::max(0, light_groups));
    } else {
      values += channel.name == kAlpha ? 1 : find_row(channel.name)->size();
    }
  }
  return values * 2 * sizeof(float);  // see SampleHalves
}

JudgedChannels::JudgedChannels(std::vector<JudgedChannel> channels, float threshold,
                               int light_groups)
    : channels_(std::move(channels)), threshold_(threshold) {
  if (channels_.empty()) channels_ = {{std::string(kPicture)}};
  assert(channels_.size() <= kMaxJudged);
  for (uint8_t k = 0; k < channels_.size(); ++k) add_values(k, light_groups);
}

void JudgedChannels::add_values(uint8_t channel, int light_groups) {
  const std::string& name = channels_[channel].name;
  const auto add = [&](int light_group, size_t count, size_t skipped) {
    values_.push_back({channel, find_row(name), light_group, value_count_, count, skipped});
    value_count_ += count;
  };
  if (name == kPicture) {
    judges_picture_ = true;
    picture_ = channel;
  } else if (name == kAlpha) {
    add(-1, 1, 3);
  } else if (name == kLights) {
    for (int group = 0; group < light_groups; ++group) add(group, 3, 0);
  } else {
    add(-1, find_row(name)->size(), 0);
  }
}

float JudgedChannels::threshold(size_t channel) const {
  const float own = channels_[channel].threshold;
  return own > 0.0f ? own : threshold_;
}

// Errors of the channel times this scale can be compared with the frame's threshold.
float JudgedChannels::relative_scale(size_t channel) const {
  return threshold_ > 0.0f ? threshold_ / threshold(channel) : 1.0f;
}

void JudgedChannels::read_values(const FilmTile& film, const Values& values, size_t i,
                                 float* out) const {
  if (values.light_group >= 0) {
    const Rgb mean = film.lights(i).mean(values.light_group);
    for (int c = 0; c < 3; ++c) out[c] = mean[c];
    return;
  }
  if (film.share_of_samples(*values.row, i) == 0.0) {
    std::fill_n(out, values.count, kNoMean);
    return;
  }
  std::array<float, kMaxValues> row;
  film.put_row(*values.row, i, row.data());
  std::copy_n(&row[values.skipped], values.count, out);
}

void JudgedChannels::read_means(const FilmTile& film, size_t i, float* means) const {
  for (const Values& values : values_) read_values(film, values, i, means + values.first);
}

// Writes for each pixel the squared error of one sample in the channel's error scale, pooled over
// neighbours. It is -1 where neither the pixel nor a neighbour has samples in both halves.
void JudgedChannels::measure(const FilmTile& film, const PixelStatistics& pixels,
                             const SampleHalves& halves, const Values& values,
                             std::vector<float>* variances) const {
  const size_t size = pixels.size();
  const ErrorScale scale = scale_of(*values.row, channels_[values.channel].name);
  const std::span<const float> weights = halves.weights();
  std::vector<float> own(size), has_own(size), across, pooled_weight;
  parallel_ranges(size, kGrain, [&](size_t begin, size_t end) {
    std::array<float, kMaxValues> mean;
    for (size_t i = begin; i < end; ++i) {
      if (!(weights[i] > 0.0f)) continue;
      read_values(film, values, i, mean.data());
      // If one of the two parts has no value (kNoMean), the difference says nothing.
      constexpr float kMaxDifference = 1e30f;
      if (std::abs(halves.differences(values.first)[i]) > kMaxDifference) continue;
      float sum = 0.0f;
      for (size_t c = 0; c < values.count; ++c) {
        const float variance = weights[i] * square(halves.differences(values.first + c)[i]);
        const float deviation = std::sqrt(variance / std::max(1.0f, pixels.count[i]));
        sum += error_weight(scale, mean[c], deviation) * variance;
      }
      // At silhouettes, often only a few of a pixel's samples have a value. Its mean is then
      // uncertain, but weighs little in the picture.
      sum *= square(float(film.share_of_samples(*values.row, i)));
      // Infinite and NaN sums count as the largest variance.
      own[i] = sum <= kMaxVariance ? sum / float(values.count) : kMaxVariance;
      has_own[i] = 1.0f;
    }
  });
  const auto width = size_t(pixels.width), height = size_t(pixels.height);
  pool_plane(has_own, width, height, &across, &pooled_weight);
  pool_plane(own, width, height, &across, variances);
  parallel_ranges(size, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      float& variance = (*variances)[i];
      variance = pooled_weight[i] > 0.0f ? variance / pooled_weight[i] : -1.0f;
    }
  });
}

// Scales the errors and deviations of R G B, or sets them to 0 if R G B are not judged.
void JudgedChannels::scale_picture(ErrorMap* errors) {
  if (judges_picture_ && recorded_ < errors->error.size()) {
    recorded_errors_[picture_] = errors->error[recorded_];
  }
  const float scale = judges_picture_ ? relative_scale(picture_) : 0.0f;
  for (float& error : errors->error) error *= scale;
  for (float& deviation : errors->deviation) deviation *= scale;
}

// Merges the errors and deviations of one channel, or of one light group, into `errors`.
void JudgedChannels::add_errors(const Values& values, const PixelStatistics& pixels,
                                std::span<const float> variances, std::span<uint8_t> furthest,
                                ErrorMap* errors) {
  const auto error_of = [&](size_t i) {
    return variances[i] < 0.0f ? kUnknownError
                               : std::sqrt(variances[i] / std::max(1.0f, pixels.count[i]));
  };
  const float scale = relative_scale(values.channel);
  const bool is_first = !judges_picture_ && &values == values_.data();
  parallel_ranges(pixels.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const float error = map_error(error_of(i) * scale);
      if (is_first || error > errors->error[i]) furthest[i] = values.channel;
      errors->error[i] = std::max(errors->error[i], error);
      errors->deviation[i] =
          std::sqrt(square(errors->deviation[i]) + std::max(0.0f, variances[i]) * square(scale));
    }
  });
  if (recorded_ >= pixels.size()) return;
  float& recorded = recorded_errors_[values.channel];
  recorded = std::max(recorded, error_of(recorded_));
}

void JudgedChannels::update(const FilmTile& film, const PixelStatistics& pixels,
                            const SampleHalves& halves, ErrorMap* errors) {
  recorded_errors_.assign(channels_.size(), 0.0f);
  scale_picture(errors);
  std::vector<uint8_t> furthest(pixels.size(), picture_);
  std::vector<float> variances;
  for (const Values& values : values_) {
    measure(film, pixels, halves, values, &variances);
    add_errors(values, pixels, variances, furthest, errors);
  }
  if (recorded_ < pixels.size()) recorded_channel_ = furthest[recorded_];
  last_.resize(pixels.size(), picture_);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const float error = errors->error[i];
    if (error > threshold_ && error < kUnknownError) last_[i] = furthest[i];
  }
}

void JudgedChannels::archive(Archive& archive, size_t pixels) {
  if (values_.empty()) return;
  archive.array(last_, pixels);
  for (const uint8_t channel : last_) archive.check(channel < channels_.size());
  archive.array(recorded_errors_, channels_.size());
  archive.number(recorded_channel_, 0u, uint32_t(channels_.size() - 1));
}

}  // namespace emberline
