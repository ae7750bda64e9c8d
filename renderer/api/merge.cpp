// Reads and merges checkpoints.
#include <tbb/task_arena.h>

#include <nlohmann/json.hpp>

#include "io/files/record_file.h"
#include "io/json/input.h"
#include "renderer/api/frame_parts.h"
#include "renderer/api/picture_sink.h"
#include "renderer/core/errors.h"
#include "renderer/output/cryptomatte_layers.h"
#include "renderer/output/frame_extension.h"
#include "renderer/output/frame_merge.h"

namespace emberline::api {
namespace {

nlohmann::json head_of(const std::string& checkpoint) {
  return parse_json(RecordFile(checkpoint).head(), checkpoint);
}

RenderedPicture merge_checkpoints(const std::vector<std::string>& checkpoints,
                                  const MergeRules& rules, const Resources& resources,
                                  const std::stop_token& stop) {
  check_resources(resources);
  if (checkpoints.empty()) throw emberline::UsageError("merge needs at least one checkpoint");
  raise_open_file_limit();  // because every part stays open
  const LoadLimits limits =
      limits_of({resources.memory_bytes, resources.load_timeout_s}, checkpoints.front());
  FrameMerge frame(checkpoints, rules.allow_holes, rules.strict, *limits.memory, stop);
  RenderOptions options;
  static_cast<FrameSettings&>(options) = frame.settings();
  options.outputs = {"picture.exr"};
  OutputSettings output = output_settings(options, frame.first().plan().crop);
  if (rules.parts) output.aovs.insert(Aov::kPart);
  const int threads = arena_threads(resources);
  const SceneLayers& layers = frame.first().layers();
  frame.reserve(options, output, threads, *limits.memory);
  limits.memory->reserve(MemoryPart::kFilm, PictureSink::bytes(output, layers),
                         checkpoints.front());
  PictureSink sink(output, layers);
  Picture picture;
  tbb::task_arena(threads).execute([&] {
    frame.deliver(output.aovs, sink);
    picture = sink.finish(stop);
  });
  if (stop.stop_requested()) throw Cancelled();
  return rendered_picture(std::move(picture), output, layers, frame.counters(),
                          frame.error_estimate(), frame.complete());
}

}  // namespace

FrameSettings settings_in(const std::string& checkpoint) {
  return stored_settings(head_of(checkpoint), checkpoint);
}

std::vector<MatteNames> names_of(const SceneLayers& layers) {
  std::vector<MatteNames> all;
  for (const CryptomatteNames& names : layers.cryptomattes) {
    all.push_back({cryptomatte_layer_name(names.kind), names.ids});
  }
  return all;
}

StoredFrame stored_frame(const std::string& checkpoint) {
  return translate_errors([&] {
    StoredFrame stored;
    const nlohmann::json head = head_of(checkpoint);
    FrameSettings& settings = Access::impl(stored.settings);
    settings = stored_settings(head, checkpoint);
    stored.scene = std::exchange(settings.scene, {});
    stored.mattes = names_of(scene_layers_of(head, checkpoint));
    return stored;
  });
}

RenderedPicture merge(const std::vector<std::string>& checkpoints, const MergeRules& rules,
                      const Resources& resources, const std::stop_token& stop) {
  return translate_errors([&] {
    try {
      return merge_checkpoints(checkpoints, rules, resources, stop);
    } catch (const Cancelled&) {
      throw Stopped("the merge was stopped");
    }
  });
}

}  // namespace emberline::api
