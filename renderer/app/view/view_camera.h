#pragma once
#include "renderer/scene/scene_edits.h"
namespace emberline {
using Vec2d = Imath::V2d;
class ViewCamera {
 public:
  ViewCamera(const CameraDescription& c, const Vec3d& pivot, double radius)
      : c_(c), pivot_(pivot), radius_(radius) {
    from_ = Vec3d(c.to_world[3][0], c.to_world[3][1], c.to_world[3][2]);
    fwd_ = -Vec3d(c.to_world[2][0], c.to_world[2][1], c.to_world[2][2]).normalized();
  }
  void orbit(const Vec2d& d) {
    rot(d);
    Vec3d o = from_ - pivot_;
    double r = o.length();
    from_ = pivot_ - fwd_ * r;
  }
  void look_around(const Vec2d& d) { rot(d * -0.5); }
  void pan(const Vec2d& d) {
    Vec3d m = right() * (-d.x * dist()) + up() * (d.y * dist());
    from_ += m;
    pivot_ += m;
  }
  void dolly(double s) { from_ = pivot_ + (from_ - pivot_) * std::pow(0.9, s); }
  void fly(const Vec3d& m) {
    Vec3d d = right() * m.x + up() * m.y + fwd_ * m.z;
    from_ += d;
    pivot_ += d;
  }
  void frame(const Vec3d& c, double r, int, int) {
    pivot_ = c;
    from_ = c - fwd_ * (3 * r);
  }
  const Vec3d& pivot() const { return pivot_; }
  double fov_y() const { return c_.fov_y; }
  CameraEdit edit(const CameraEdit& b) const {
    CameraEdit e = b;
    e.camera.reset();
    e.look_from = from_;
    e.look_at = from_ + fwd_ * dist();
    return e;
  }

 private:
  double dist() const { return (from_ - pivot_).length(); }
  Vec3d right() const { return fwd_.cross(Vec3d(0, 1, 0)).normalized(); }
  Vec3d up() const { return right().cross(fwd_); }
  void rot(const Vec2d& d) {
    double yaw = std::atan2(fwd_.x, -fwd_.z) + 3 * d.x,
           pitch = std::clamp(std::asin(fwd_.y) - 3 * d.y, -1.5, 1.5);
    fwd_ =
        Vec3d(std::sin(yaw) * std::cos(pitch), std::sin(pitch), -std::cos(yaw) * std::cos(pitch));
  }
  CameraDescription c_;
  Vec3d pivot_, from_, fwd_;
  double radius_;
};
}  // namespace emberline
