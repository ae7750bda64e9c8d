// Converts linear radiance to display pixels through OpenColorIO and writes PNG and JPEG.
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
  std::string display;    // empty: the config's default display
  std::string view;       // empty: the display's default view
  std::string look;       // empty: none
  float exposure = 0.0f;  // in stops, applied before the view

  bool operator==(const DisplaySettings&) const = default;
};

// The valid names for DisplaySettings, as the current config spells them. Defaults come first.
struct DisplayNames {
  struct Display {
    std::string name;
    std::vector<std::string> views;
  };
  std::vector<Display> displays;
  std::vector<std::string> looks;
};
// Throws InputError if $OCIO is set but cannot be read.
DisplayNames display_names();

// Returns the files that the config in $OCIO names, if they exist. Returns nothing if $OCIO is
// unset or its config is damaged.
std::vector<std::string> ocio_table_files();

// Converts from linear Rec. 709, or another working space, to a display.
//
// If $OCIO is unset or empty, uses OpenColorIO's built-in transforms and no files. There is one
// display, "sRGB", with three views: "sRGB" (default; the curve of IEC 61966-2-1, clamped), "ACES"
// (the ACES 1.0 SDR video output transform, shown on an sRGB display) and "Raw" (no curve).
//
// Otherwise uses the config that $OCIO names. The input space is the first of these that the config
// has:
//   1. linear Rec. 709, if a space has one of the usual names for it;
//   2. the role aces_interchange; OpenColorIO's own matrices convert pixels to ACES2065-1 first;
//   3. the role scene_linear; pixels are not converted, but a warning says so, since colours are
//      slightly off if this space has other primaries.
class DisplayTransform {
 public:
  // `from` is the input's working space. For an unknown display, view or look (case does not
  // matter), throws a UsageError that lists the valid names. Throws InputError if $OCIO is set but
  // cannot be read or used.
  explicit DisplayTransform(const DisplaySettings& settings,
                            WorkingSpace from = WorkingSpace::kRec709);
  ~DisplayTransform();

  // Converts interleaved RGB floats in place. NaN becomes 0, and values are clamped to the range of
  // half, so the result is always finite. Thread-safe.
  void apply(float* rgb, size_t pixel_count) const;

  // Whether an output channel depends on the pixel's other channels.
  bool mixes_channels() const;

  // Returns text such as "built-in: sRGB / ACES", for headers and reports.
  std::string describe() const;

  // Whether the result is meant for an sRGB display, judging by the display's name. If so, files
  // are tagged as sRGB.
  bool is_srgb() const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

// Collects tiles as 8-bit display pixels, and writes the data window as a PNG or JPEG (by suffix).
// Like ExrWriter, creates the file beside its target at once, so that an unusable path fails before
// rendering, and renames it in finish(). Without finish(), nothing is left behind. Needs 3 or
// 4 bytes of memory per pixel. Pixels that are never written are black (and transparent). Does not
// dither, so identical radiance gives identical bytes.
class DisplayImageWriter {
 public:
  // If `alpha`, a PNG has four channels with unassociated alpha, as the PNG format requires, and a
  // JPEG shows the picture over black. Throws RenderError if the file cannot be created, and
  // UsageError for a suffix other than .png, .jpg and .jpeg.
  DisplayImageWriter(const std::string& path, const Rect& data_window,
                     std::shared_ptr<const DisplayTransform> transform, bool alpha);

  // `rgba` holds rect.area() x 4 linear floats with premultiplied alpha, rows from rect.y0. `rect`
  // must lie in the data window. Thread-safe for disjoint rectangles.
  void write_tile(const Rect& rect, const std::vector<float>& rgba);

  const std::string& path() const { return file_.path(); }
  // Size in bytes of the picture, which is in memory from construction on.
  uint64_t bytes() const { return image_.values.capacity(); }

  // Encodes and writes the file, and marks it as unfinished unless `complete`
  // (image/file_completeness.h). Call once, after all threads have stopped writing. Throws
  // RenderError.
  void finish(bool complete = true);

 private:
  const std::string format_;
  const Rect data_window_;
  const std::shared_ptr<const DisplayTransform> transform_;
  AtomicFile file_;
  ByteImage image_;
};

// Writes a whole image with a DisplayImageWriter.
void write_display_image(const std::string& path, const Rect& data_window,
                         std::shared_ptr<const DisplayTransform> transform, bool alpha,
                         const std::vector<float>& rgba);

}  // namespace emberline
