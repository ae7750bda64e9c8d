#include "renderer/app/view/render_session.h"

#include <utility>

namespace emberline {

class RenderSession::Impl {
 public:
  explicit Impl(ViewSettings s) : settings(std::move(s)) {}
  ViewSettings settings;
  SceneEdits edits;
};

RenderSession::RenderSession(ViewSettings settings)
    : impl_(std::make_unique<Impl>(std::move(settings))) {}
RenderSession::~RenderSession() = default;
void RenderSession::open(const std::string&, const std::string&) {}
void RenderSession::cancel_load() {}
LoadStatus RenderSession::load_status() { return {}; }
std::shared_ptr<const OpenScene> RenderSession::scene() const { return nullptr; }
const ViewSettings& RenderSession::settings() const { return impl_->settings; }
void RenderSession::set_settings(const ViewSettings& settings) { impl_->settings = settings; }
uint64_t RenderSession::edit() const { return 0; }
const SceneEdits& RenderSession::edits() const { return impl_->edits; }
void RenderSession::set_edits(const SceneEdits& edits, const std::optional<LightEdit>&) {
  impl_->edits = edits;
}
uint64_t RenderSession::bvh_builds() const { return 0; }
std::shared_ptr<const ShownPicture> RenderSession::picture() const { return nullptr; }
std::string RenderSession::problem() const { return {}; }
void RenderSession::on_change(std::function<void()>) {}
std::optional<PixelInspection> RenderSession::inspect(int, int) { return std::nullopt; }
void RenderSession::end_inspection() {}
std::future<void> RenderSession::save(const std::string&) { return {}; }
std::future<void> RenderSession::save_heatmap(const std::string&, ViewOverlay) { return {}; }
std::future<void> RenderSession::save_edits(const std::string&) { return {}; }

}  // namespace emberline
