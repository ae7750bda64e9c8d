// Pictures of a RenderSession, and inspections of single pixels.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/core/rect.h"
#include "renderer/core/vector.h"
#include "renderer/engine/render_sink.h"

namespace emberline {

// A picture and its state. Immutable once published.
struct ShownPicture {
  uint64_t edit = 0;    // the last edit that it shows: what RenderSession::edit() returned
  uint64_t serial = 0;  // grows from picture to picture
  int width = 0, height = 0;
  int x = 0, y = 0;  // in the frame, of which it may be a crop
  Rect rect() const { return {x, y, x + width, y + height}; }
  // `filled`: all pixels show this edit, some perhaps a neighbour's sample; otherwise the previous
  // picture is visible around a region. `complete`: every pixel has a sample of its own; with
  // buckets, all of its samples.
  bool filled = false;
  bool complete = false;
  bool finished = false;          // nothing more will come
  std::vector<uint8_t> rgba8;     // as displayed, overlay included; rows from the top
  std::vector<float> rgba;        // linear Rec. 709, premultiplied, as the film has it
  std::vector<float> denoised;    // the same filtered, if that is what rgba8 shows; else empty
  std::vector<uint8_t> raw8;      // as rgba8, not filtered: ViewSettings::raw_beside; else empty
  std::vector<Rect> in_progress;  // buckets under way
  JobProgress progress;
  uint64_t samples = 0;        // of this frame so far
  uint64_t rays = 0;           // likewise; of a bucket frame, when it has finished
  double elapsed_s = 0.0;      // since the edit
  double rendering_s = 0.0;    // of this frame, pauses left out: rays / rendering_s is the pace
  std::string driver;          // which one is at work: of `live` and `bucket`, "bisection" first
  std::string overlay_legend;  // what the colours run from and to: "1 to 64 samples per pixel"

  // The linear picture that rgba8 shows.
  const std::vector<float>& linear() const { return denoised.empty() ? rgba : denoised; }
};

// An inspection of one pixel.
struct PixelInspection {
  int x = 0, y = 0;
  uint64_t edit = 0;  // of the picture that it is of
  Rgb radiance;       // with alpha: as in the newest picture
  float alpha = 0.0f;
  std::optional<Rgb> denoised;  // where the picture is
  // The members below describe the frame's last pause, shortly before or after that picture. Before
  // the first pause since the request, `known` is false and they are invalid.
  bool known = false;
  uint32_t samples = 0;
  std::optional<Rgb> variance;  // of the mean, where the film has it: adaptive, or error overlay
  uint32_t non_finite = 0;      // samples that counted as black
  PixelStop stop = PixelStop::kNone;  // as far as it is known; kGoingOn where more may come
  uint32_t id = 0;                    // 1 + instance; 0: background
  std::string object;                 // its node, or its mesh
  int material = -1;                  // into ListedScene::outline's materials; -1: nothing hit
  Vec3d position = Vec3d(0.0);        // of the surface hit, world space
  std::string explanation;            // FrameDriver::explain; of the picked pixel alone
};

}  // namespace emberline
