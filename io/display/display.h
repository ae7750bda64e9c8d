// Linear radiance to display pixels through OpenColorIO, and PNG/JPEG out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/display/choices.h"
#include "io/files/atomic_file.h"
#include "io/image/output.h"
#include "renderer/core/rect.h"

namespace emberline {

struct DisplaySettings {
  std::string display;    // empty: the config's default
  std::string view;       // empty: the display's default view
  std::string look;       // empty: none
  float exposure = 0.0f;  // stops, before the view

  bool operator==(const DisplaySettings&) const = default;
};

// What DisplaySettings can name, as the config in use spells it; the defaults first.
struct DisplayNames {
  struct Display {
    std::string name;
    std::vector<std::string> views;
  };
  std::vector<Display> displays;
  std::vector<std::string> looks;
};
// Throws InputError when $OCIO is set but cannot be read.
DisplayNames display_names();

// The files that the config of $OCIO names and that are there; none without, or if it is damaged.
std::vector<std::string> display_tables();

// The transform from linear Rec. 709 to a display.
//
// With $OCIO unset or empty it is built from OpenColorIO's built-in transforms, without any file:
// display "sRGB" with the views "sRGB" (default; the curve of IEC 61966-2-1, clamped), "ACES" (the
// ACES 1.0 SDR video output transform, shown on an sRGB display) and "Raw" (no curve).
//
// With $OCIO set that config decides. Our pixels enter it, in this order of preference, as
//   1. its space of linear Rec. 709 primaries, if it has one under one of the usual names;
//   2. its role aces_interchange, converted to ACES2065-1 by OpenColorIO's own matrices;
//   3. its role scene_linear as they are, with a warning: colours are then a little off if that
//      space has other primaries.
class DisplayTransform {
 public:
  // Throws UsageError that lists the valid names for an unknown display, view or look (upper and
  // lower case are alike), InputError when $OCIO is set but cannot be read or used.
  // `from` is what comes in, if it is not linear Rec. 709.
  explicit DisplayTransform(const DisplaySettings& settings,
                            WorkingSpace from = WorkingSpace::kRec709);
  ~DisplayTransform();

  // In place, interleaved RGB floats; thread-safe. NaN counts as 0, and values beyond half's range
  // (infinity too) as its largest, so that the result is finite whatever comes in.
  void apply(float* rgb, size_t pixel_count) const;

  // Whether a channel of the result depends on the others of the pixel.
  bool mixes_channels() const;

  // "built-in: sRGB / ACES", for headers and reports.
  std::string describe() const;

  // Whether the result is meant for an sRGB display as far as we know (to tag files with).
  bool is_srgb() const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

// Collects tiles as 8-bit display pixels and writes a PNG or JPEG (by suffix) of the data window.
// Same rule as ExrWriter: the file is created beside its target at once, so that an unusable path
// is known before rendering, and renamed in finish(); without finish() nothing is left behind.
// Holds 3 or 4 bytes per pixel. Pixels never written are black (and transparent). No dithering:
// equal radiance gives equal bytes.
class DisplayImageWriter {
 public:
  // With `alpha` a PNG has four channels, colour not multiplied by alpha, as the format wants it;
  // a JPEG has none, and shows the picture over black. Throws RenderError when the file cannot be
  // created, UsageError for a suffix other than .png, .jpg and .jpeg.
  DisplayImageWriter(const std::string& path, const Rect& data_window,
                     std::shared_ptr<const DisplayTransform> transform, bool alpha);

  // `rgba` holds rect.area() x 4 linear floats (premultiplied alpha), rows from rect.y0; `rect`
  // lies in the data window. Thread-safe for disjoint rectangles.
  void write_tile(const Rect& rect, const std::vector<float>& rgba);

  const std::string& path() const { return file_.path(); }
  // What is held from construction on: the picture.
  uint64_t bytes() const { return image_.values.capacity(); }

  // Encodes and writes. Call once, when no thread writes any more. Throws RenderError.
  // The file says so where its frame is not `complete` (image/picture_mark.h).
  void finish(bool complete = true);

 private:
  const std::string format_;
  const Rect data_window_;
  const std::shared_ptr<const DisplayTransform> transform_;
  AtomicFile file_;
  ByteImage image_;
};

// A picture that is held as a whole, by a DisplayImageWriter.
void write_display_image(const std::string& path, const Rect& data_window,
                         std::shared_ptr<const DisplayTransform> transform, bool alpha,
                         const std::vector<float>& rgba);

}  // namespace emberline
