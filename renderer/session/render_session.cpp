#include "renderer/session/render_session.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "io/files/register.h"
#include "io/json/edits_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/output/heatmap_file.h"
#include "renderer/output/outputs.h"
#include "renderer/output/report.h"
#include "renderer/session/overlay_picture.h"
#include "renderer/session/scene_loader.h"
#include "renderer/session/view_renderer.h"

namespace emberline {
namespace {

// Writes the picture atomically. A .exr contains all channels with linear values; a .png or .jpg
// contains display values. A .png has alpha if the environment is transparent. Throws UsageError
// for another suffix, and RenderError.
void write_picture(const std::string& path, const FilmCopy& film, const DisplaySettings& display) {
  if (lower_suffix(path) == ".exr") {
    write_film_exr(path, film.aovs, film.options.width, film.options.height, film.crop,
                   settings_attributes(film.options), film.channels);
    return;
  }
  const size_t channels = film_channels(film.aovs).size(), pixels = film.channels.size() / channels;
  std::vector<float> rgba(4 * pixels);
  for (size_t i = 0; i < pixels; ++i) std::copy_n(&film.channels[channels * i], 4, &rgba[4 * i]);
  write_display_image(path, film.crop, std::make_shared<DisplayTransform>(display),
                      film.options.transparent, rgba);
}

// Throws UsageError for an overlay that is not a heatmap.
const HeatmapQuantity& heatmap_of(ViewOverlay overlay) {
  const HeatmapQuantity* quantity = overlay_quantity(overlay);
  if (!quantity) throw UsageError("this overlay is not a heatmap; save the picture instead");
  return *quantity;
}

// Writes a heatmap. A .png or .jpg shows it with its legend; a .exr contains its values. Throws
// UsageError if the overlay is not a heatmap, and RenderError if the film lacks its channel.
void write_heatmap(const std::string& path, const FilmCopy& film, ViewOverlay overlay) {
  const HeatmapQuantity& quantity = heatmap_of(overlay);
  const Rect& crop = film.crop;
  check_heatmap_format("heatmap", path, crop);
  // If the driver reports stop reasons, they are known without the channel, even before the frame
  // is finished.
  const bool is_categorical = quantity.categories && !film.stops.empty();
  const std::vector<std::string> names =
      is_categorical ? std::vector<std::string>{"stop"} : film_channel_names(film.aovs);
  const std::string missing = QuantityPlane::missing_channel(quantity, names);
  if (!missing.empty()) {
    throw RenderError(path + ": the frame was rendered without the channel " + missing +
                      "; show its overlay first, then save again");
  }
  HeatmapFile file(
      {path, &quantity}, film.options.heatmap_style,
      {film.options.width, film.options.height, crop, settings_attributes(film.options)}, names);
  file.write_tile(crop, is_categorical ? film.stops : film.channels);
  file.finish();
}

}  // namespace

using InspectionTarget = ViewRenderer::InspectionTarget;

RenderSession::RenderSession(ViewSettings settings)
    : settings_(std::move(settings)),
      rendered_settings_(settings_),
      publisher_(std::make_unique<PicturePublisher>()),
      writer_(std::make_unique<TaskThread>()),
      loader_(std::make_unique<SceneLoader>([this] { publisher_->wake(); })),
      renderer_(std::make_unique<ViewRenderer>(*publisher_)) {
  publisher_->set_display(settings_.display);
  renderer_->set_display_mode(settings_.display_mode());
  renderer_->set_paused(settings_.paused);
}

RenderSession::~RenderSession() {
  on_change({});
  loader_->cancel();
}

// With `only_edits`, the current frame still shows its first picture before it ends, so that new
// pictures keep appearing during a drag.
void RenderSession::post(bool only_edits) {
  ++edit_;
  rendered_settings_ = settings_;
  if (!scene_) return;
  publisher_->set_problem("");  // any problem concerned the previous edit
  SceneEdits effective = solo_ ? with_solo(edits_, *solo_, *scene_) : edits_;
  renderer_->post({edit_, ViewClock::now(), scene_, std::move(effective), settings_}, only_edits);
}

void RenderSession::adopt(std::shared_ptr<LoadedScene> loaded) {
  scene_ = std::move(loaded);
  edits_ = scene_->edits;
  solo_.reset();
  post(false);
}

void RenderSession::open(const std::string& scene, const std::string& edits_file) {
  RenderOptions options = main_options(settings_);
  options.scene = scene;
  options.edits = edits_file;
  loader_->load(options);
}

void RenderSession::cancel_load() { loader_->cancel(); }

LoadStatus RenderSession::load_status() {
  std::shared_ptr<LoadedScene> new_scene;
  LoadStatus status = loader_->poll(&new_scene);
  if (new_scene) adopt(std::move(new_scene));
  return status;
}

std::shared_ptr<const ListedScene> RenderSession::scene() const {
  return scene_ ? scene_->open : nullptr;
}

std::shared_ptr<MemoryBudget> RenderSession::memory() const {
  return scene_ ? scene_->memory.budget() : nullptr;
}

void RenderSession::set_settings(const ViewSettings& settings) {
  const ViewSettings before = std::exchange(settings_, settings);
  if (before.display != settings.display) {
    publisher_->set_display(settings.display);
    if (settings.overlay == ViewOverlay::kTree) renderer_->republish();
  }
  if (before.paused != settings.paused) renderer_->set_paused(settings.paused);
  if (before.display_mode() != settings.display_mode())
    renderer_->set_display_mode(settings.display_mode());
  if (!frame_satisfies(rendered_settings_, settings)) post(false);
}

void RenderSession::set_edits(const SceneEdits& edits, const std::optional<LightEdit>& solo) {
  if (!scene_) return;
  check_edits(edits, *scene_);
  if (solo) edited_light_index(*solo, scene_->edit_lists);
  if (edits == edits_ && solo == solo_) return;
  edits_ = edits;
  solo_ = solo;
  post(true);
}

std::shared_ptr<const SessionPicture> RenderSession::picture() const {
  return publisher_->picture();
}

void RenderSession::compare_with(std::shared_ptr<const SessionPicture> comparison) {
  publisher_->compare_with(std::move(comparison));
}

std::shared_ptr<const SessionPicture> RenderSession::graded_comparison() const {
  return publisher_->graded_comparison();
}

std::string RenderSession::problem() const { return publisher_->problem(); }

void RenderSession::on_change(std::function<void()> wake) {
  publisher_->on_change(std::move(wake));
}

// Merges the pixel's values in the newest picture with the latest inspection of this pixel.
std::optional<PixelInspection> RenderSession::inspection_at(const Vec2i& at, bool picked) const {
  const std::shared_ptr<const SessionPicture> picture = publisher_->picture();
  if (!picture || !picture->rect().contains(at.x, at.y)) {
    return std::nullopt;
  }
  PixelInspection result;
  const std::optional<PixelInspection> known =
      renderer_->inspection(picked ? InspectionTarget::kPicked : InspectionTarget::kPointed);
  if (known && known->edit == picture->edit && Vec2i(known->x, known->y) == at) result = *known;
  result.x = at.x;
  result.y = at.y;
  result.edit = picture->edit;
  const size_t first = 4 * picture->rect().index_of(at.x, at.y);
  const float* rgba = &picture->rgba[first];
  result.radiance = {rgba[0], rgba[1], rgba[2]};
  result.alpha = rgba[3];
  if (!picture->denoised.empty()) {
    const float* shown = &picture->denoised[first];
    result.denoised = Rgb(shown[0], shown[1], shown[2]);
  }
  return result;
}

std::optional<PixelInspection> RenderSession::inspect(int x, int y) {
  const Vec2i at(x, y);
  const std::optional<PixelInspection> inspection = inspection_at(at, false);
  if (inspection && inspected_ != at) {
    inspected_ = at;
    renderer_->inspect(InspectionTarget::kPointed, inspected_);
  }
  return inspection;
}

void RenderSession::end_inspection() {
  inspected_.reset();
  renderer_->inspect(InspectionTarget::kPointed, std::nullopt);
}

void RenderSession::pick(const std::optional<Vec2i>& pixel) {
  if (picked_ == pixel) return;
  picked_ = pixel;
  renderer_->inspect(InspectionTarget::kPicked, pixel);
}

std::optional<PixelInspection> RenderSession::picked() const {
  return picked_ ? inspection_at(*picked_, true) : std::nullopt;
}

// Runs `write` on the writer thread, unless `path` is an input file of the open scene.
std::future<void> RenderSession::save_in_background(const std::string& path,
                                                    const std::function<void()>& write) {
  auto done = std::make_shared<std::promise<void>>();
  std::future<void> result = done->get_future();
  writer_->post([=, open = scene(), environment = edits_.environment.file] {
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

// Like save_in_background(), but calls `write` with a copy of the current film.
std::future<void> RenderSession::save_film(const std::string& path,
                                           const std::function<void(const FilmCopy&)>& write) {
  auto film = std::make_shared<std::future<FilmCopy>>(renderer_->copy());
  return save_in_background(path, [film, write] { write(film->get()); });
}

std::future<void> RenderSession::save(const std::string& path) {
  return save_film(path, [path, display = settings_.display](const FilmCopy& film) {
    write_picture(path, film, display);
  });
}

std::future<void> RenderSession::save_heatmap(const std::string& path, ViewOverlay quantity) {
  heatmap_of(quantity);
  return save_film(path,
                   [path, quantity](const FilmCopy& film) { write_heatmap(path, film, quantity); });
}

std::future<void> RenderSession::save_edits(const std::string& path) {
  const SceneEdits edits = scene_ ? with_view(edits_, settings_.render, *scene_) : edits_;
  return save_in_background(path, [path, edits] { write_edits(path, edits); });
}

}  // namespace emberline
