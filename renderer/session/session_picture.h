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

// A picture, and the frame's state when the picture was made. Immutable once published.
struct SessionPicture {
  uint64_t edit = 0;    // the last edit that the picture shows; see RenderSession::edit()
  uint64_t serial = 0;  // increases with each picture
  int width = 0, height = 0;
  int x = 0, y = 0;  // position in the frame; 0 if the frame is not cropped
  Rect rect() const { return {x, y, x + width, y + height}; }
  // `filled` means that every pixel shows this edit, although a pixel may still show a neighbour's
  // sample. It is false while only a region shows this edit, and the previous picture surrounds it.
  // `complete` means that every pixel has its own sample or, with buckets, all of its samples.
  bool filled = false;
  bool complete = false;
  bool finished = false;          // the last picture of the frame
  std::vector<uint8_t> rgba8;     // display values including the overlay; top row first
  std::vector<float> rgba;        // linear Rec. 709, premultiplied, from the film
  std::vector<float> denoised;    // filtered `rgba`, if that is what rgba8 shows; else empty
  std::vector<uint8_t> raw8;      // unfiltered rgba8, with ViewSettings::include_raw; else empty
  std::vector<Rect> in_progress;  // buckets being rendered
  JobProgress progress;
  uint64_t samples = 0;        // samples of this frame so far
  uint64_t rays = 0;           // rays of this frame so far; with buckets, only set at the end
  double elapsed_s = 0.0;      // time since the edit
  double rendering_s = 0.0;    // time of this frame without pauses, for rays per second
  std::string driver;          // current driver; `live` and `bucket` begin with "bisection"
  std::string overlay_legend;  // the range of the colours: "1 to 64 samples per pixel"

  // The linear picture that rgba8 shows.
  const std::vector<float>& linear() const { return denoised.empty() ? rgba : denoised; }
};

// An inspection of one pixel.
struct PixelInspection {
  int x = 0, y = 0;
  uint64_t edit = 0;  // SessionPicture::edit of the inspected picture
  Rgb radiance;       // `radiance` and `alpha` are as in the newest picture
  float alpha = 0.0f;
  std::optional<Rgb> denoised;  // if the picture is denoised
  // The following members describe the state at the frame's last pause, which is shortly before or
  // after the newest picture. They are invalid while `known` is false, that is, before the first
  // pause after the request.
  bool known = false;
  uint32_t samples = 0;
  std::optional<Rgb>
      variance;             // variance of the mean, if recorded (adaptive driver or error overlay)
  uint32_t non_finite = 0;  // number of samples that were not finite and count as black
  PixelStop stop = PixelStop::kNone;  // kUnfinished if more samples may come
  uint32_t id = 0;                    // 1 + instance; 0 for the background
  std::string object;                 // name of the instance's node or mesh
  int material = -1;            // index in the materials of ListedScene::outline; -1 if nothing was
                                // hit
  Vec3d position = Vec3d(0.0);  // point on the visible surface, in world space
  std::string explanation;      // FrameDriver::explain(); only for the picked pixel
};

}  // namespace emberline
