#include "renderer/statistics/heatmap_legend.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "renderer/statistics/text_font.h"

namespace emberline {
namespace {

constexpr Rgb8 kBackground = {30, 30, 30}, kEdge = {140, 140, 140}, kTitle = {255, 255, 255},
               kText = {205, 205, 205}, kHistogram = {150, 150, 150};

// An em is 18 pixels at 1280x720 and 54 at 3840x2160. At the minimum of 11 pixels, the x-height is
// 6 pixels and the height of capitals is 8, so that letters are sharp without hinting. Smaller
// letters are hard to read.
constexpr double kLetterFraction = 18.0 / 960;
constexpr int kMinLetter = 11;

// Sizes and gaps, in em.
constexpr double kPadding = 0.7, kLineGap = 0.35, kItemGap = 1.6, kSwatch = 0.73, kSwatchGap = 0.4;
constexpr double kHistogramHeight = 2.4, kBarHeight = 0.9, kTickHeight = 0.3, kTickGap = 0.1;
constexpr double kBinWidth = 0.2, kMaxBinWidth = 0.8, kBorder = 0.09;
constexpr double kMinWidth = 20, kMinTickSpacing = 4.8, kLabelGap = 0.6;

int letter_size(int width, int height) {
  const double side = std::sqrt(double(width) * double(height));
  return std::max(kMinLetter, int(std::lround(kLetterFraction * side)));
}

int pixels_of(double ems, int letter) { return std::max(1, int(std::lround(ems * letter))); }

// An item, or one line of an item that is wider than the legend.
struct LegendPiece {
  LegendItem item;
  Rgb8 colour;
  int width = 0;
  bool ends_line = false;
};

class LegendBuilder {
 public:
  LegendBuilder(int width, int height) : font_(letter_size(width, height)) {
    layout_.letter = letter_size(width, height);
    layout_.line = px(kBorder);
    layout_.frame = {0, 0, width, height};
    content_width_ = std::max(width, px(kMinWidth)) - 2 * px(kPadding);
  }

  LegendLayout build(std::span<const LegendItem> items, const LegendBar* bar) {
    std::vector<LegendPiece> pieces;
    for (const LegendItem& item : items) add_pieces(item, pieces.empty() ? kTitle : kText, &pieces);
    for (const LegendPiece& piece : pieces) content_width_ = std::max(content_width_, piece.width);
    int y = layout_.frame.y1 + layout_.line + px(kPadding);
    y = place_pieces(pieces, y);
    if (bar) y = place_bar(*bar, y + px(kLineGap));
    layout_.picture = {0, 0, content_width_ + 2 * px(kPadding), y + px(kPadding)};
    return std::move(layout_);
  }

 private:
  int px(double ems) const { return pixels_of(ems, layout_.letter); }

  int swatch_width(const LegendItem& item) const {
    return item.swatch ? px(kSwatch) + px(kSwatchGap) : 0;
  }

  // Splits an item that is wider than the legend into lines, between words. No other item follows
  // on the last of these lines, so that the next item does not look like a continuation.
  void add_pieces(const LegendItem& item, const Rgb8& colour,
                  std::vector<LegendPiece>* pieces) const {
    LegendItem rest = item;
    for (;;) {
      size_t end = rest.text.size();
      const auto width = [&] {
        return swatch_width(rest) + font_.width(std::string_view(rest.text).substr(0, end));
      };
      while (width() > content_width_) {
        const size_t space = rest.text.rfind(' ', end - 1);
        if (space == std::string::npos || space == 0) break;
        end = space;
      }
      const bool last = end == rest.text.size();
      const bool broken = rest.text.size() < item.text.size();
      pieces->push_back(
          {{rest.text.substr(0, end), rest.swatch}, colour, width(), broken || !last});
      if (last) return;
      rest = {rest.text.substr(end + 1)};
    }
  }

  // Returns the lower end of the last line.
  int place_pieces(const std::vector<LegendPiece>& pieces, int y) {
    const int left = px(kPadding);
    int x = left;
    bool full = false;
    for (const LegendPiece& piece : pieces) {
      if (full || (x > left && x + piece.width > left + content_width_)) {
        x = left;
        y += font_.height() + px(kLineGap);
      }
      if (piece.item.swatch) {
        // The swatch stands on the baseline and is as high as a capital letter.
        const int bottom = y + font_.ascent(), side = px(kSwatch);
        layout_.swatches.push_back({{x, bottom - side, x + side, bottom}, *piece.item.swatch});
      }
      const int begin = x + swatch_width(piece.item);
      x += piece.width;
      layout_.texts.push_back({piece.item.text, {begin, y, x, y + font_.height()}, piece.colour});
      x += px(kItemGap);
      full = piece.ends_line;
    }
    return y + font_.height();
  }

  // Returns the lower end of the labels.
  int place_bar(const LegendBar& bar, int y) {
    const int left = px(kPadding), right = left + content_width_;
    layout_.histogram = {left, y, right, y + px(kHistogramHeight)};
    layout_.bar = {left, layout_.histogram.y1, right, layout_.histogram.y1 + px(kBarHeight)};
    const int top = layout_.bar.y1, label_top = top + px(kTickHeight) + px(kTickGap);
    int next_free = left;
    for (const AxisTick& tick :
         bar.scale.ticks(std::max(2, content_width_ / px(kMinTickSpacing)), bar.factor)) {
      const double position = std::clamp(bar.scale.position(tick.value), 0.0, 1.0);
      const int x = left + int(std::lround(position * (content_width_ - layout_.line)));
      layout_.ticks.push_back({x, top, x + layout_.line, top + px(kTickHeight)});
      const int width = font_.width(tick.label);
      const int begin =
          std::clamp(x - (width - layout_.line) / 2, left, std::max(left, right - width));
      if (begin < next_free) continue;
      layout_.tick_labels.push_back(
          {tick.label, {begin, label_top, begin + width, label_top + font_.height()}, kText});
      next_free = begin + width + px(kLabelGap);
    }
    return label_top + font_.height();
  }

  TextFont font_;
  LegendLayout layout_;
  int content_width_ = 0;  // width between the left and right padding
};

bool whole_numbers(const Plane& plane) {
  return std::ranges::all_of(plane.values,
                             [](float v) { return !std::isfinite(v) || v == std::round(v); });
}

// A histogram with bins of equal width over the scale. If all values are whole numbers and the
// scale is linear, each bin covers the same number of whole numbers, and the first bin begins 0.5
// below the scale.
struct Bins {
  std::vector<uint64_t> counts;
  double first = 0,
         bin = 0;  // start of the first bin and width of a bin, as fractions of the scale
};

Bins histogram_of(const LegendBar& bar, int bins) {
  const ValueRange& range = bar.scale.range();
  const double length = range.max - range.min;
  Bins h;
  h.bin = 1.0 / bins;
  if (!bar.scale.logarithmic() && whole_numbers(bar.plane)) {
    h.bin = std::ceil(length / bins) / length;
    h.first = -0.5 / length;
  }
  h.counts.assign(size_t(std::ceil((1.0 - h.first) / h.bin)), 0);
  for (const float value : bar.plane.values) {
    const double position = bar.scale.position(double(value));
    if (!(position >= 0.0 && position <= 1.0)) continue;
    h.counts[std::min(size_t((position - h.first) / h.bin), h.counts.size() - 1)]++;
  }
  return h;
}

void draw_histogram(BytePicture& picture, const LegendLayout& layout, const LegendBar& bar) {
  const Rect& area = layout.histogram;
  const Bins h = histogram_of(bar, std::max(1, area.width() / pixels_of(kBinWidth, layout.letter)));
  const uint64_t max = *std::ranges::max_element(h.counts);
  const double width =
      std::min(h.bin * area.width(), double(pixels_of(kMaxBinWidth, layout.letter)));
  for (size_t i = 0; i < h.counts.size(); ++i) {
    if (h.counts[i] == 0) continue;
    const double middle = area.x0 + (h.first + (double(i) + 0.5) * h.bin) * area.width();
    const int x0 = std::clamp(int(std::lround(middle - 0.5 * width)), area.x0, area.x1 - 1);
    const int x1 = std::clamp(int(std::lround(middle + 0.5 * width)), x0 + 1, area.x1);
    // If a bin is not empty, its column is at least as high as a border is thick.
    const double share = double(h.counts[i]) / double(max);
    const int height = std::max(layout.line, int(std::lround(share * area.height())));
    picture.fill({x0, area.y1 - height, x1, area.y1}, kHistogram);
  }
}

void draw_bar(BytePicture& picture, const LegendLayout& layout, const LegendBar& bar) {
  const Rect& area = layout.bar;
  for (int x = area.x0; x < area.x1; ++x) {
    const double position = (x - area.x0 + 0.5) / area.width();
    picture.fill({x, area.y0, x + 1, area.y1}, colour_of(bar.colours, position));
  }
  for (const Rect& tick : layout.ticks) picture.fill(tick, kEdge);
}

}  // namespace

LegendLayout lay_out_legend(int width, int height, std::span<const LegendItem> items,
                            const LegendBar* bar) {
  return LegendBuilder(width, height).build(items, bar);
}

BytePicture draw_legend(const LegendLayout& layout, const LegendBar* bar) {
  const Rect &whole = layout.picture, &frame = layout.frame;
  const int line = layout.line;
  BytePicture picture(whole.x1, whole.y1, kBackground);
  picture.fill({0, frame.y1, whole.x1, frame.y1 + line}, kEdge);
  if (frame.x1 < whole.x1) picture.fill({frame.x1, 0, frame.x1 + line, frame.y1}, kEdge);
  for (const LegendLayout::Swatch& swatch : layout.swatches) {
    const Rect& box = swatch.box;
    picture.fill(box, kEdge);
    picture.fill({box.x0 + line, box.y0 + line, box.x1 - line, box.y1 - line}, swatch.colour);
  }
  if (bar) {
    draw_histogram(picture, layout, *bar);
    draw_bar(picture, layout, *bar);
  }
  const TextFont font(layout.letter);
  for (const auto* texts : {&layout.texts, &layout.tick_labels}) {
    for (const LegendLayout::Text& text : *texts) {
      font.draw(picture, text.box.x0, text.box.y0, text.text, text.colour);
    }
  }
  return picture;
}

}  // namespace emberline
