#include "renderer/window/picture/placement.h"

#include <algorithm>
#include <cmath>

namespace emberline {
namespace {

// At least this many screen pixels of a dragged picture stay visible.
constexpr double kMinVisible = 32.0;

}  // namespace

void PicturePlacement::place(const Rect& area, int width, int height) {
  if (area == area_ && width == width_ && height == height_) return;
  const double middle_x = 0.5 * (area_.x0 + area_.x1), middle_y = 0.5 * (area_.y0 + area_.y1);
  const double x = (middle_x - left_) / zoom_, y = (middle_y - top_) / zoom_;
  area_ = area;
  width_ = width;
  height_ = height;
  if (fitted_) return apply_fit();
  left_ = 0.5 * (area.x0 + area.x1) - x * zoom_;
  top_ = 0.5 * (area.y0 + area.y1) - y * zoom_;
  keep_visible();
}

void PicturePlacement::fit() {
  fitted_ = true;
  apply_fit();
}

void PicturePlacement::apply_fit() {
  if (width_ < 1 || height_ < 1 || area_.empty()) return;
  zoom_ = std::clamp(std::min(double(area_.width()) / width_, double(area_.height()) / height_),
                     kMinZoom, kMaxZoom);
  // Snaps to whole screen pixels, so that a picture shown at 1:1 is not blurred.
  left_ = std::floor(area_.x0 + 0.5 * (area_.width() - zoom_ * width_));
  top_ = std::floor(area_.y0 + 0.5 * (area_.height() - zoom_ * height_));
}

void PicturePlacement::zoom_to(double zoom, const Vec2f& screen) {
  const double scale = std::clamp(zoom, kMinZoom, kMaxZoom) / zoom_;
  fitted_ = false;
  zoom_ *= scale;
  left_ = std::round(screen.x - (screen.x - left_) * scale);
  top_ = std::round(screen.y - (screen.y - top_) * scale);
  keep_visible();
}

void PicturePlacement::zoom_to(double zoom) {
  zoom_to(zoom, Vec2f(0.5f * float(area_.x0 + area_.x1), 0.5f * float(area_.y0 + area_.y1)));
}

void PicturePlacement::drag(const Vec2f& screen_delta) {
  fitted_ = false;
  left_ += screen_delta.x;
  top_ += screen_delta.y;
  keep_visible();
}

void PicturePlacement::keep_visible() {
  const double margin_x = std::min(kMinVisible, zoom_ * width_);
  const double margin_y = std::min(kMinVisible, zoom_ * height_);
  left_ = std::min(std::max(left_, area_.x0 + margin_x - zoom_ * width_), area_.x1 - margin_x);
  top_ = std::min(std::max(top_, area_.y0 + margin_y - zoom_ * height_), area_.y1 - margin_y);
}

Vec2f PicturePlacement::to_screen(const Vec2f& picture) const {
  return {float(left_ + zoom_ * picture.x), float(top_ + zoom_ * picture.y)};
}

Vec2f PicturePlacement::to_picture(const Vec2f& screen) const {
  return {float((screen.x - left_) / zoom_), float((screen.y - top_) / zoom_)};
}

std::optional<Vec2i> PicturePlacement::pixel_at(const Vec2f& screen) const {
  if (screen.x < float(area_.x0) || screen.x >= float(area_.x1) || screen.y < float(area_.y0) ||
      screen.y >= float(area_.y1)) {
    return std::nullopt;
  }
  const Vec2f at = to_picture(screen);
  const Vec2i pixel(int(std::floor(at.x)), int(std::floor(at.y)));
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= width_ || pixel.y >= height_) return std::nullopt;
  return pixel;
}

}  // namespace emberline
