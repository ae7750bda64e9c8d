// Linear radiance to display pixels through OpenColorIO, and PNG/JPEG out through OpenImageIO.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline {

struct DisplaySettings {
  std::string display;  // empty: the config's default
  std::string view;     // empty: the display's default view
  std::string look;     // empty: none
  float exposure = 0.0f;  // stops, before the view
};

// The transform from linear Rec. 709 to a display, from $OCIO when it is set and usable, else from
// a built-in config made of OCIO's built-in transforms: display "sRGB" with views "sRGB" (default,
// plain curve), "ACES" (ACES 1.x SDR video output transform) and "Raw".
class DisplayTransform {
 public:
  // Throws UsageError that lists the valid names for an unknown display, view or look, InputError
  // when $OCIO is set but cannot be read.
  explicit DisplayTransform(const DisplaySettings& settings);
  ~DisplayTransform();

  // In place, interleaved RGB floats; thread-safe.
  void apply(float* rgb, size_t pixel_count) const;

  // "built-in: sRGB / ACES", for headers and reports.
  std::string describe() const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

// Collects tiles as 8-bit display pixels and writes a PNG or JPEG (by suffix) of the data window.
// Same write-beside-and-rename rule as ExrWriter.
class DisplayImageWriter {
 public:
  DisplayImageWriter(const std::string& path, const Rect& data_window,
                     std::shared_ptr<const DisplayTransform> transform, bool alpha);
  ~DisplayImageWriter();

  // `rgba` holds rect.area() x 4 linear floats (premultiplied alpha), rows from rect.y0.
  // Thread-safe for disjoint rectangles.
  void write_tile(const Rect& rect, const std::vector<float>& rgba);
  void finish();  // throws RenderError

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace emberline
