#include "renderer/statistics/study/denoise.h"

#include <algorithm>

#include "renderer/engine/render_clock.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/denoise_pass.h"

namespace emberline {
namespace {

constexpr size_t kResults = 4;  // of denoise_results() without light groups: R G B and the error

}  // namespace

void denoise_picture(const Rect& crop, StudyPicture* picture) {
  AovSet aovs;
  aovs.insert(Aov::kDenoising);
  const std::vector<std::string> names = film_channel_names(aovs);
  std::vector<float> denoised(size_t(crop.area()) * kStudyPictureChannels);
  const DenoiseJob job = {
      .crop = crop,
      .channels = names,
      .tile_size = kStudyTile,
      .read =
          [&](const Rect& rows, std::vector<float>& pixels) {
            const float* first = &picture->values[crop.index_of(rows.x0, rows.y0) * names.size()];
            pixels.assign(first, first + size_t(rows.area()) * names.size());
          },
      .write =
          [&](const Rect& tile, const std::vector<float>& pixels) {
            const size_t stride = pixels.size() / size_t(tile.area()), results = stride - kResults;
            for (size_t i = 0; i < size_t(tile.area()); ++i) {
              const float* pixel = &pixels[i * stride];
              float* to =
                  &denoised[crop.index_of(tile.x_of(i), tile.y_of(i)) * kStudyPictureChannels];
              std::copy_n(pixel, kStudyPictureChannels, to);
              std::copy_n(pixel + results, 3, to);
            }
          }};
  const RenderClock clock;
  const DenoiseReport report = denoise_films(job);
  const double cpu = clock.cpu_seconds();
  picture->wall_s += clock.seconds();
  picture->cpu_s += cpu;
  picture->filter = {cpu, report.kept_share};
  picture->estimate = report.error_after;
  picture->values = std::move(denoised);
}

}  // namespace emberline
