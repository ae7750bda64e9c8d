#include "renderer/output/report_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/film/film.h"
#include "renderer/output/heatmap_file.h"
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {

ReportPictures::ReportPictures(const RenderOptions& options, const Rect& crop, const AovSet& aovs)
    : transform_(options.display, options.working_space),
      crop_(crop),
      film_channels_(film_channel_names(aovs)),
      judged_(judged_names(options)),
      picture_(crop, kMaxPixels) {
  const size_t pixels = picture_.size();
  for (const HeatmapQuantity& quantity : heatmap_quantity_table()) {
    if (quantity.aov && !aovs.contains(*quantity.aov)) continue;
    if (quantity.categories == judged_categories && judged_.size() < 2) continue;
    const auto channels = QuantityPlane::find_channels(quantity, film_channels_);
    if (!channels) continue;
    maps_.push_back(
        {&quantity, *channels, std::vector<float>(pixels, 0.0f), std::vector<uint32_t>(pixels, 0)});
  }
}

std::vector<float> ReportPictures::evaluate_maps(std::span<const float> film) const {
  const size_t stride = film_channels_.size(), pixels = film.size() / stride;
  std::vector<float> values, arguments;
  values.reserve(maps_.size() * pixels);
  for (const MapSums& map : maps_) {
    arguments.resize(map.channels.size());
    for (size_t i = 0; i < pixels; ++i) {
      std::ranges::transform(map.channels, arguments.begin(),
                             [&](size_t c) { return film[i * stride + c]; });
      values.push_back(map.quantity->value(arguments.data()));
    }
  }
  return values;
}

void ReportPictures::add(const FilmTile& tile) {
  std::vector<float> film;
  tile.resolve(film);
  const std::vector<float> values = evaluate_maps(film);
  const Rect& rect = tile.rect();
  const size_t stride = film_channels_.size(), pixels = size_t(rect.area());
  std::map<uint32_t, uint64_t> counts;
  auto count = counts.end();  // cached, because neighbouring pixels mostly have equal counts
  for (size_t i = 0; i < pixels; ++i) {
    const uint32_t samples = tile.sample_count(rect.x_of(i), rect.y_of(i));
    if (count == counts.end() || count->first != samples) count = counts.try_emplace(samples).first;
    ++count->second;
  }
  // If the frame is scaled down, several tiles can contribute to the same pixel of these pictures.
  const std::lock_guard lock(mutex_);
  for (const auto& [samples, number] : counts) pixels_by_samples_[samples] += number;
  picture_.add(rect, film, stride);
  for (size_t i = 0; i < pixels; ++i) {
    const int x = rect.x_of(i), y = rect.y_of(i);
    const size_t target = picture_.index_of(x, y);
    const bool first = (x - crop_.x0) % factor() == 0 && (y - crop_.y0) % factor() == 0;
    for (size_t m = 0; m < maps_.size(); ++m) {
      const float value = values[m * pixels + i];
      if (!std::isfinite(value) || (maps_[m].quantity->categories && !first)) continue;
      maps_[m].sums[target] += maps_[m].quantity->rms ? value * value : value;
      ++maps_[m].counts[target];
    }
  }
}

std::vector<ReportPictures::Map> ReportPictures::maps() const {
  std::vector<Map> maps;
  for (const MapSums& sums : maps_) {
    // Pixels for which no tile was added have channels of 0, as in the EXR.
    const std::vector<float> zeros(sums.channels.size(), 0.0f);
    const float default_value = sums.quantity->value(zeros.data());
    Plane plane{picture_.width(), picture_.height(), sums.sums};
    for (size_t i = 0; i < plane.values.size(); ++i) {
      const float mean = sums.counts[i] > 0 ? plane.values[i] / float(sums.counts[i])
                                            : std::numeric_limits<float>::quiet_NaN();
      plane.values[i] = !picture_.has(i)     ? default_value
                        : sums.quantity->rms ? std::sqrt(mean)
                                             : mean;
    }
    maps.push_back({sums.quantity, std::move(plane)});
  }
  return maps;
}

std::map<uint32_t, uint64_t> ReportPictures::pixels_by_samples() const {
  std::map<uint32_t, uint64_t> pixels = pixels_by_samples_;
  uint64_t counted = 0;
  for (const auto& [samples, count] : pixels) counted += count;
  // In a stopped frame, some tiles were never started. Their pixels have no samples.
  if (counted < uint64_t(crop_.area())) pixels[0] += uint64_t(crop_.area()) - counted;
  return pixels;
}

uint64_t ReportPictures::bytes() const {
  uint64_t bytes = picture_.bytes();
  for (const MapSums& map : maps_) {
    bytes += map.sums.capacity() * sizeof(float) + map.counts.capacity() * sizeof(uint32_t);
  }
  return bytes;
}

}  // namespace emberline
