// Heatmaps of pictures.
#include "renderer/api/access.h"
#include "renderer/core/utf8.h"
#include "renderer/output/heatmap_file.h"

namespace emberline::api {
namespace {

Plane plane_of(const HeatmapQuantity& quantity, const Picture& picture) {
  check_heatmap_channels("the picture", quantity, picture.channels);
  const Rect pixels{picture.x, picture.y, picture.x + picture.width, picture.y + picture.height};
  QuantityPlane plane(quantity, picture.channels, pixels);
  plane.write_tile(pixels, picture.values);
  return plane.plane();
}

HeatmapStyle style_of(const HeatmapLook& look) {
  HeatmapStyle style;
  style.colours = parse_colour_map(look.colors);
  style.logarithmic = look.log;
  style.plain = look.plain;
  if (!look.range) return style;
  const auto [minimum, maximum] = *look.range;
  if (!is_valid_heatmap_range(minimum, maximum)) {
    throw emberline::UsageError("`range`: {}, {} is not a valid range", minimum, maximum);
  }
  style.range = ValueRange{minimum, maximum};
  return style;
}

}  // namespace

std::vector<HeatmapKind> heatmap_kinds() {
  std::vector<HeatmapKind> kinds;
  for (const HeatmapQuantity& quantity : heatmap_quantity_table()) {
    kinds.push_back({std::string(quantity.name), std::string(quantity.summary), {}});
    for (const std::string_view channel : quantity.channels) {
      kinds.back().channels.emplace_back(channel);
    }
  }
  return kinds;
}

std::vector<float> heatmap_values(const Picture& picture, const std::string& of) {
  return translate_errors([&] {
    check_picture("the picture", picture);
    return plane_of(find_heatmap_quantity(of, "of"), picture).values;
  });
}

DisplayedPicture heatmap(const Picture& picture, const std::string& of, const HeatmapLook& look) {
  return translate_errors([&] {
    check_picture("the picture", picture);
    const HeatmapQuantity& quantity = find_heatmap_quantity(of, "of");
    const HeatmapStyle style = style_of(look);
    const HeatmapQuantity* const quantities[] = {&quantity};
    check_heatmap_style(style, quantities);
    BytePicture drawn = draw_quantity(quantity, plane_of(quantity, picture), style);
    return DisplayedPicture{drawn.width, drawn.height, std::move(drawn.values)};
  });
}

}  // namespace emberline::api
