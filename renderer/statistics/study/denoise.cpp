#include "renderer/statistics/study/denoise.h"

#include <algorithm>

#include "renderer/engine/render_clock.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/denoise_pass.h"

namespace emberline {

void denoise_picture(const Rect& crop, StudyPicture* picture) {
  AovSet aovs;
  aovs.insert(Aov::kDenoising);
  const std::vector<std::string> names = film_channel_names(aovs);
  const size_t results = denoise_results(names).size();
  std::vector<float> denoised(size_t(crop.area()) * kStudyPictureChannels);
  const auto write = [&](const Rect& tile, const std::vector<float>& pixels) {
    const size_t stride = pixels.size() / size_t(tile.area());
    for (size_t i = 0; i < size_t(tile.area()); ++i) {
      const float* pixel = &pixels[i * stride];
      float* to = &denoised[crop.index_of(tile.x_of(i), tile.y_of(i)) * kStudyPictureChannels];
      std::copy_n(pixel, kStudyPictureChannels, to);
      std::copy_n(pixel + stride - results, 3, to);
    }
  };
  const RenderClock clock;
  const DenoiseReport report = denoise_film(crop, kStudyTile, names, picture->values, write);
  const double cpu = clock.cpu_seconds();
  picture->wall_s += clock.seconds();
  picture->cpu_s += cpu;
  picture->filter = {cpu, report.kept_share};
  picture->estimate = report.error_after;
  picture->values = std::move(denoised);
}

}  // namespace emberline
