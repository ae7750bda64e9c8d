#include "renderer/session/render_session.h"

#include <utility>

#include "io/edits_file.h"
#include "io/file_register.h"
#include "renderer/core/errors.h"
#include "renderer/session/picture_files.h"
#include "renderer/session/scene_loader.h"
#include "renderer/session/view_renderer.h"

namespace emberline {
namespace {

using Look = ViewRenderer::Look;

bool same_display(const DisplaySettings& a, const DisplaySettings& b) {
  return a.display == b.display && a.view == b.view && a.look == b.look && a.exposure == b.exposure;
}

}  // namespace

// The owner's side: what was asked for last. All else is in the threads of its members.
class RenderSession::Impl {
 public:
  explicit Impl(ViewSettings given)
      : settings(std::move(given)),
        rendered_settings(settings),
        loader([this] { publisher.wake(); }),
        renderer(publisher) {
    publisher.set_display(settings.display);
    renderer.set_overlay(settings.overlay);
    renderer.set_paused(settings.paused);
  }

  // Edits of a drag wait for the picture of the one before.
  void post(bool only_edits) {
    ++edit;
    rendered_settings = settings;
    if (!scene) return;
    publisher.set_problem("");  // what it said was of the edit before
    SceneEdits effective = solo ? with_solo(edits, *solo, *scene) : edits;
    renderer.post({edit, ViewClock::now(), scene, std::move(effective), settings}, only_edits);
  }

  void adopt(std::shared_ptr<LoadedScene> loaded) {
    scene = std::move(loaded);
    edits = scene->edits;
    solo.reset();
    post(false);
  }

  // `write` gets the film as it stands now, on the writing thread.
  template <typename Write>
  std::future<void> save(const std::string& path, Write write) {
    auto film = std::make_shared<std::future<FilmCopy>>(renderer.copy());
    return later(path, [film, write] { write(film->get()); });
  }
  // `write` writes to `path`, unless that is a file that something open was read from.
  template <typename Write>
  std::future<void> later(const std::string& path, Write write) {
    auto done = std::make_shared<std::promise<void>>();
    std::future<void> result = done->get_future();
    writer.post([=, open = scene ? scene->open : nullptr, environment = edits.environment.file] {
      try {
        FileRegister files;
        files.write("saving to", path);
        if (open) files.read(open->inputs, "the scene reads");
        if (!environment.empty()) files.read(environment, "it is the environment of the edits");
        write();
        done->set_value();
      } catch (...) {
        done->set_exception(std::current_exception());
      }
    });
    return result;
  }

  // What the newest picture shows of the pixel, with all else that is known of it there.
  std::optional<PixelInspection> look(Look look, const Vec2i& at) const {
    const std::shared_ptr<const ShownPicture> picture = publisher.picture();
    if (!picture || !Rect{0, 0, picture->width, picture->height}.contains(at.x, at.y)) {
      return std::nullopt;
    }
    PixelInspection result;
    const std::optional<PixelInspection> known = renderer.inspection(look);
    if (known && known->edit == picture->edit && Vec2i(known->x, known->y) == at) result = *known;
    result.x = at.x;
    result.y = at.y;
    result.edit = picture->edit;
    const float* rgba = &picture->rgba[4 * (size_t(at.y) * size_t(picture->width) + size_t(at.x))];
    result.radiance = {rgba[0], rgba[1], rgba[2]};
    result.alpha = rgba[3];
    return result;
  }

  ViewSettings settings;
  ViewSettings rendered_settings;  // of the newest request
  uint64_t edit = 0;
  std::shared_ptr<LoadedScene> scene;
  SceneEdits edits;
  std::optional<LightEdit> solo;
  std::optional<Vec2i> inspected, picked;

  // In the order of their use: each may still call those before it while it ends.
  PicturePublisher publisher;
  TaskThread writer;
  SceneLoader loader;
  ViewRenderer renderer;
};

RenderSession::RenderSession(ViewSettings settings)
    : impl_(std::make_unique<Impl>(std::move(settings))) {}

RenderSession::~RenderSession() {
  on_change({});
  impl_->loader.cancel();
}

void RenderSession::open(const std::string& scene, const std::string& edits_file) {
  RenderOptions options = main_options(impl_->settings);
  options.scene = scene;
  options.edits = edits_file;
  impl_->loader.load(options);
}

void RenderSession::cancel_load() { impl_->loader.cancel(); }

LoadStatus RenderSession::load_status() {
  std::shared_ptr<LoadedScene> arrived;
  LoadStatus status = impl_->loader.poll(&arrived);
  if (arrived) impl_->adopt(std::move(arrived));
  return status;
}

std::shared_ptr<const OpenScene> RenderSession::scene() const {
  return impl_->scene ? impl_->scene->open : nullptr;
}

const ViewSettings& RenderSession::settings() const { return impl_->settings; }

void RenderSession::set_settings(const ViewSettings& settings) {
  Impl& session = *impl_;
  const ViewSettings before = std::exchange(session.settings, settings);
  if (!same_display(before.display, settings.display)) {
    session.publisher.set_display(settings.display);
    if (settings.overlay == ViewOverlay::kTree) session.renderer.show_again();
  }
  if (before.paused != settings.paused) session.renderer.set_paused(settings.paused);
  if (before.overlay != settings.overlay) session.renderer.set_overlay(settings.overlay);
  if (!frames_serve(session.rendered_settings, settings)) session.post(false);
}

uint64_t RenderSession::edit() const { return impl_->edit; }

const SceneEdits& RenderSession::edits() const { return impl_->edits; }

void RenderSession::set_edits(const SceneEdits& edits, const std::optional<LightEdit>& solo) {
  Impl& session = *impl_;
  if (!session.scene) return;
  check_edits(edits, *session.scene);
  if (solo) edited_light(*solo, session.scene->edit_lists);
  if (edits == session.edits && solo == session.solo) return;
  session.edits = edits;
  session.solo = solo;
  session.post(true);
}

uint64_t RenderSession::bvh_builds() const { return impl_->renderer.bvh_builds(); }

std::shared_ptr<const ShownPicture> RenderSession::picture() const {
  return impl_->publisher.picture();
}

void RenderSession::compare_with(std::shared_ptr<const ShownPicture> kept) {
  impl_->publisher.compare_with(std::move(kept));
}

std::shared_ptr<const ShownPicture> RenderSession::compared() const {
  return impl_->publisher.compared();
}

std::string RenderSession::problem() const { return impl_->publisher.problem(); }

void RenderSession::on_change(std::function<void()> wake) {
  impl_->publisher.on_change(std::move(wake));
}

std::optional<PixelInspection> RenderSession::inspect(int x, int y) {
  Impl& session = *impl_;
  const std::optional<PixelInspection> known = session.look(Look::kPointed, {x, y});
  if (known && session.inspected != Vec2i(x, y)) {
    session.inspected = Vec2i(x, y);
    session.renderer.inspect(Look::kPointed, session.inspected);
  }
  return known;
}

void RenderSession::end_inspection() {
  impl_->inspected.reset();
  impl_->renderer.inspect(Look::kPointed, std::nullopt);
}

void RenderSession::pick(const std::optional<Vec2i>& pixel) {
  if (impl_->picked == pixel) return;
  impl_->picked = pixel;
  impl_->renderer.inspect(Look::kPicked, pixel);
}

std::optional<PixelInspection> RenderSession::picked() const {
  if (!impl_->picked) return std::nullopt;
  return impl_->look(Look::kPicked, *impl_->picked);
}

std::future<void> RenderSession::save(const std::string& path) {
  return impl_->save(path, [path, display = impl_->settings.display](const FilmCopy& film) {
    write_picture(path, film, display);
  });
}

std::future<void> RenderSession::save_heatmap(const std::string& path, ViewOverlay quantity) {
  heatmap_of(quantity);
  return impl_->save(
      path, [path, quantity](const FilmCopy& film) { write_heatmap(path, film, quantity); });
}

std::future<void> RenderSession::save_edits(const std::string& path) {
  const SceneEdits edits =
      impl_->scene ? with_view(impl_->edits, impl_->settings.render, *impl_->scene) : impl_->edits;
  return impl_->later(path, [path, edits] { write_edits(path, edits); });
}

}  // namespace emberline
