#include "renderer/statistics/study/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <filesystem>
#include <optional>

#include "io/files/input_file.h"
#include "io/image/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/readable.h"
#include "renderer/core/rect_values.h"
#include "renderer/core/summed_area_table.h"
#include "renderer/engine/run_limits.h"
#include "renderer/statistics/heatmap_quantity.h"
#include "renderer/statistics/study_summary.h"

namespace emberline {
namespace {

// Maximum width and height of a picture on the page, in pixels. Larger pictures are downsampled by
// averaging.
constexpr int kMaxPixels = 1280;
// Maximum number of pictures in a row of figures, and the width of such a row in pixels.
constexpr int kMaxColumns = 4, kPageWidth = 1300;

struct MethodPictures {
  std::string name, caption;
  std::optional<ByteImage> picture, flip;
  std::optional<Plane> samples;
};

// The folder of a study, and the number of pixels that each picture in it must have.
struct PictureFolder {
  std::string path;
  int64_t pixels;

  std::string file(const std::string& name) const {
    return (std::filesystem::path(path) / name).string();
  }
};

// Returns the picture with three channels of 8 bits; nothing if the file is missing or unreadable.
std::optional<ByteImage> read_picture(const PictureFolder& folder, const std::string& name) {
  if (name.empty()) return std::nullopt;
  try {
    const std::string path = folder.file(name);
    const LoadProgress bounded({}, {}, read_back_limits(folder.pixels));
    const InputFile encoded(path);
    const MemoryReservation bytes(bounded.budget(), MemoryPart::kFile, encoded.size(), path);
    const auto file = decode_image(encoded.read_all(), path, false, bounded).image;
    if (file->type != TexelType::kUint8 || file->channels < 3) return std::nullopt;
    ByteImage image{.width = file->width, .height = file->height, .values = {}};
    const auto channels = size_t(file->channels);
    for (size_t i = 0; i < file->texels.size(); i += channels) {
      for (size_t c = 0; c < 3; ++c) image.values.push_back(uint8_t(file->texels[i + c]));
    }
    return image;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

std::optional<Plane> read_samples(const PictureFolder& folder, const std::string& name) {
  if (name.empty()) return std::nullopt;
  try {
    const FloatImage file =
        read_float_image(folder.file(name), LoadProgress({}, {}, read_back_limits(folder.pixels)));
    const int channel = file.find_channel("samples");
    if (channel < 0) return std::nullopt;
    Plane plane{file.width, file.height, {}};
    for (size_t i = size_t(channel); i < file.values.size(); i += size_t(file.channels())) {
      plane.values.push_back(file.values[i]);
    }
    return plane;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

MethodPictures read_method(const StudyResults& results, size_t m, const PictureFolder& folder) {
  const StudyMethod& method = results.methods[m];
  const StudyMethod::Pictures& p = method.pictures;
  std::string caption = fmt::format("{}: {} samples per pixel in {}", method.name,
                                    readable_number(p.mean_samples, 4), readable_seconds(p.wall_s));
  const StudyRun* run = find_run(results, m, p.seed);
  if (run && !run->checkpoints.empty()) {
    const StudyError& error = run->checkpoints.back().error;
    caption += fmt::format("; FLIP {}, relmse {}", readable_number(error.flip),
                           readable_number(error.rel_mse));
  }
  return {method.name, std::move(caption), read_picture(folder, p.png),
          read_picture(folder, p.flip_png), read_samples(folder, p.exr)};
}

// Returns how many pictures of this width to show in a row.
int column_count(int width) { return std::clamp(kPageWidth / std::max(1, width), 2, kMaxColumns); }

ByteImage downsample(const ByteImage& image) {
  const int factor = (std::max(image.width, image.height) + kMaxPixels - 1) / kMaxPixels;
  if (factor <= 1) return image;
  ByteImage small{.width = (image.width + factor - 1) / factor,
                  .height = (image.height + factor - 1) / factor,
                  .values = {}};
  const Rect whole{0, 0, image.width, image.height};
  for (int y = 0; y < whole.y1; y += factor) {
    for (int x = 0; x < whole.x1; x += factor) {
      const Rect square = Rect{x, y, x + factor, y + factor}.intersect(whole);
      for (size_t c = 0; c < 3; ++c) {
        uint32_t sum = 0;
        for (size_t i = 0; i < size_t(square.area()); ++i) {
          sum += image.values[3 * whole.index_of(square.x_of(i), square.y_of(i)) + c];
        }
        small.values.push_back(uint8_t(sum / uint32_t(square.area())));
      }
    }
  }
  return small;
}

PageFigure figure(const ByteImage& image, const char* format, const std::string& caption,
                  bool magnified = false) {
  return {picture_markup(encode_image(image, format, "the study's picture"),
                         fmt::format("image/{}", format), image.width, image.height, caption,
                         magnified),
          caption};
}

ByteImage crop_image(const ByteImage& image, const Rect& part) {
  return {.width = part.width(),
          .height = part.height(),
          .values = extract_rect(image.values, Rect{0, 0, image.width, image.height}, part)};
}

bool same_size(const ByteImage& a, const ByteImage& b) {
  return a.width == b.width && a.height == b.height;
}

// Chooses the crops in which the baseline's error is largest. If the baseline has no usable
// picture, the first method that has one takes its place.
std::vector<Rect> choose_crops(const StudyResults& results,
                               const std::vector<MethodPictures>& methods,
                               const ByteImage& reference) {
  const auto usable = [&](size_t m) {
    return methods[m].picture && same_size(*methods[m].picture, reference);
  };
  size_t chosen = baseline_method(results).value_or(0);
  for (size_t m = 0; m < methods.size() && !usable(chosen); ++m) chosen = m;
  if (chosen >= methods.size() || !usable(chosen)) return {};
  const int side = std::clamp(std::min(reference.width, reference.height) / 6, 8, 96);
  return most_different_squares(*methods[chosen].picture, reference, side, 3);
}

void add_crops(HtmlPage& page, const StudyResults& results,
               const std::vector<MethodPictures>& methods, const ByteImage& reference) {
  const std::vector<Rect> crops = choose_crops(results, methods, reference);
  if (crops.empty()) return;
  page.heading("Crops where the baseline differs most from the reference");
  for (const Rect& crop : crops) {
    std::vector<PageFigure> row = {
        figure(crop_image(reference, crop), "png",
               fmt::format("reference, {},{} to {},{}", crop.x0, crop.y0, crop.x1, crop.y1), true)};
    for (const MethodPictures& m : methods) {
      if (!m.picture || !same_size(*m.picture, reference)) continue;
      row.push_back(figure(crop_image(*m.picture, crop), "png", m.name, true));
    }
    page.figures(row, kMaxColumns);
  }
}

void add_flip_maps(HtmlPage& page, const std::vector<MethodPictures>& methods, int width) {
  std::vector<PageFigure> figures;
  for (const MethodPictures& m : methods) {
    if (m.flip) figures.push_back(figure(downsample(*m.flip), "jpeg", m.name));
  }
  if (figures.empty()) return;
  page.heading("FLIP against the reference");
  page.paragraph(
      "The difference that an observer sees when flipping between the picture and the reference: "
      "black is none, bright is large (0 to 1).");
  page.figures(figures, column_count(width));
}

// All heatmaps use the same scale, so that they can be compared.
void add_heatmaps(HtmlPage& page, const std::vector<MethodPictures>& methods, int width) {
  HeatmapStyle style;
  style.range = ValueRange{0, 0};
  for (const MethodPictures& m : methods) {
    if (!m.samples) continue;
    style.range->max = std::max(style.range->max, automatic_range(*m.samples, false).max);
  }
  if (!(style.range->max > 0)) return;
  page.heading("Where the samples went");
  std::vector<PageFigure> figures;
  for (const MethodPictures& m : methods) {
    if (!m.samples) continue;
    figures.push_back(
        figure(draw_quantity(find_heatmap_quantity("samples"), *m.samples, style), "png", m.name));
  }
  page.figures(figures, column_count(width));
}

uint64_t squared_difference(const ByteImage& a, const ByteImage& b, size_t pixel) {
  uint64_t square = 0;
  for (size_t c = 3 * pixel; c < 3 * pixel + 3; ++c) {
    const int d = int(a.values[c]) - int(b.values[c]);
    square += uint64_t(d * d);
  }
  return square;
}

}  // namespace

std::vector<Rect> most_different_squares(const ByteImage& picture, const ByteImage& reference,
                                         int side, size_t count) {
  assert(same_size(picture, reference) && picture.channels == 3 && reference.channels == 3);
  const SummedAreaTable differences(picture.width, picture.height, [&](size_t pixel) {
    return squared_difference(picture, reference, pixel);
  });
  struct Candidate {
    uint64_t difference;
    Rect square;
  };
  std::vector<Candidate> candidates;
  const int step = std::max(1, side / 4);
  for (int y = 0; y + side <= picture.height; y += step) {
    for (int x = 0; x + side <= picture.width; x += step) {
      const Rect square{x, y, x + side, y + side};
      candidates.push_back({differences(square), square});
    }
  }
  std::ranges::stable_sort(candidates, std::greater<>(), &Candidate::difference);
  std::vector<Rect> chosen;
  for (const Candidate& candidate : candidates) {
    if (chosen.size() == count) break;
    const bool overlaps = std::ranges::any_of(
        chosen, [&](const Rect& other) { return !candidate.square.intersect(other).empty(); });
    if (!overlaps) chosen.push_back(candidate.square);
  }
  return chosen;
}

void add_study_pictures(HtmlPage& page, const StudyResults& results, const std::string& path) {
  const PictureFolder folder{path, int64_t(results.settings.width) * results.settings.height};
  std::vector<MethodPictures> methods;
  for (size_t m = 0; m < results.methods.size(); ++m) {
    methods.push_back(read_method(results, m, folder));
  }
  const std::optional<ByteImage> reference = read_picture(folder, results.reference.png);

  std::vector<PageFigure> figures;
  if (reference) figures.push_back(figure(downsample(*reference), "jpeg", "reference"));
  for (const MethodPictures& m : methods) {
    if (m.picture) figures.push_back(figure(downsample(*m.picture), "jpeg", m.caption));
  }
  if (figures.empty()) return;
  page.section(results.settings.by_time ? "Pictures at equal time" : "Pictures at equal samples");
  if (!results.settings.budgets.empty()) {
    page.paragraph(fmt::format(
        "Pictures of the first seed at the largest budget, {}.",
        results.settings.by_time
            ? fmt::format("{} of rendering", readable_seconds(results.settings.budgets.back()))
            : fmt::format("{} samples per pixel",
                          readable_number(results.settings.budgets.back(), 6))));
  }
  page.figures(figures, column_count(results.settings.width));
  if (reference) add_crops(page, results, methods, *reference);
  add_flip_maps(page, methods, results.settings.width);
  add_heatmaps(page, methods, results.settings.width);
}

}  // namespace emberline
