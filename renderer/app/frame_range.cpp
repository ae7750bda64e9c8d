#include "renderer/app/frame_range.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <unordered_set>

#include "io/files/atomic_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

struct FrameSpan {
  int first = 0, last = 0;
  int64_t step = 1;  // distance between frames; > 0 even if `last` < `first`

  int64_t count() const { return std::abs(int64_t(last) - first) / step + 1; }
};

[[noreturn]] void throw_invalid_frames(std::string_view text, std::string_view why) {
  throw UsageError(fmt::format("--frames: '{}' {}", shortened(text), why));
}

std::optional<int> frame_number(std::string_view text) {
  const std::optional<int> number = parse_number<int>(text);
  return number && std::abs(int64_t(*number)) <= kLastFrame ? number : std::nullopt;
}

// Parses one item of a list: "5", "1-100" or "1-100x2".
FrameSpan parse_span(std::string_view item) {
  constexpr const char* kValid =
      "is not a list of frames; valid are N, A-B and A-BxSTEP, separated by commas, with frames "
      "from -999999999 to 999999999 and a step of at least 1";
  FrameSpan span;
  const size_t x = item.find('x');
  const std::string_view range = item.substr(0, x);
  if (x != std::string_view::npos) {
    const auto step = frame_number(item.substr(x + 1));
    if (!step || *step < 1) throw_invalid_frames(item, kValid);
    span.step = *step;
  }
  const size_t dash = range.find('-', 1);  // the first character may be a sign
  const auto first = frame_number(range.substr(0, dash));
  const auto last = dash == std::string_view::npos ? first : frame_number(range.substr(dash + 1));
  if (!first || !last || (dash == std::string_view::npos && x != std::string_view::npos)) {
    throw_invalid_frames(item, kValid);
  }
  span.first = *first;
  span.last = *last;
  return span;
}

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

// Calls visit(option, path) for each output of which every frame has its own file.
template <typename Options, typename Visit>
void visit_outputs(Options& o, const Visit& visit) {
  for (auto& path : o.outputs) visit("-o", path);
  for (auto& path : o.heatmaps) visit("--heatmap", path);
  for (auto& path : o.reports) visit("--report", path);
  for (auto& path : o.trees) visit("--tree", path);
  if (!o.checkpoint.empty()) visit("--checkpoint", o.checkpoint);
  if (!o.snapshots.empty()) visit("--snapshots", o.snapshots);
}

// Throws UsageError if the name of an output has no frame number, or if two outputs have the same
// name, even in different frames.
void check_names(const RenderOptions& options, std::span<const int> frames) {
  size_t count = 0;
  visit_outputs(options, [&](const char* option, const std::string& path) {
    ++count;
    check_frame_number(option, path, options.frames.empty() ? "--turntable" : "--frames");
  });
  if (count < 2) return;
  std::unordered_set<std::string> names;
  for (const int frame : frames) {
    visit_outputs(options, [&](const char* option, const std::string& path) {
      if (names.insert(expand_frame_number(path, frame)).second) return;
      throw UsageError("{} {}: for frame {} this is {}, which is already an output", option, path,
                       frame, expand_frame_number(path, frame));
    });
  }
}

}  // namespace

std::vector<int> parse_frames(std::string_view text) {
  std::vector<int> frames;
  std::unordered_set<int> listed;
  int64_t count = 0;  // including repeated frames, because a short text may repeat a long range
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const FrameSpan span = parse_span(trimmed(text.substr(begin, end - begin)));
    begin = end + 1;
    count += span.count();
    if (count > int64_t(kMaxFrames)) {
      throw_invalid_frames(text, fmt::format("has more than {} frames", kMaxFrames));
    }
    const int64_t step = span.last < span.first ? -span.step : span.step;
    for (int64_t i = 0; i < span.count(); ++i) {
      const auto frame = int(span.first + i * step);
      if (listed.insert(frame).second) frames.push_back(frame);
    }
  }
  return frames;
}

std::string format_frames(std::span<const int> frames) {
  std::string text;
  for (size_t i = 0, end = 0; i < frames.size(); i = end) {
    end = i + 1;
    const int64_t step = end < frames.size() ? int64_t(frames[end]) - frames[i] : 0;
    while (end < frames.size() && int64_t(frames[end]) - frames[end - 1] == step) ++end;
    if (end == i + 2 && std::abs(step) != 1) --end;  // "1,3" is shorter than "1-3x2"
    text += fmt::format("{}{}", text.empty() ? "" : ",", frames[i]);
    if (end > i + 1) text += fmt::format("-{}", frames[end - 1]);
    if (end > i + 1 && std::abs(step) != 1) text += fmt::format("x{}", std::abs(step));
  }
  return text;
}

bool has_frame_number(std::string_view name) { return name.find('#') != std::string_view::npos; }

std::string expand_frame_number(std::string_view name, int frame) {
  std::string result;
  while (!name.empty()) {
    const size_t begin = std::min(name.find('#'), name.size());
    const size_t end = std::min(name.find_first_not_of('#', begin), name.size());
    result += name.substr(0, begin);
    if (end > begin) result += fmt::format("{:0{}}", frame, end - begin);
    name.remove_prefix(end);
  }
  return result;
}

void check_frame_number(std::string_view option, const std::string& path, std::string_view frames) {
  if (has_frame_number(path)) return;
  std::filesystem::path example = path;
  example.replace_extension(".####" + example.extension().string());
  throw UsageError(
      "{} {}: every frame of {} would be written to this file; put #### where the frame number "
      "goes: {}",
      option, path, frames, example.string());
}

bool is_sequence(const std::string& name) {
  std::error_code error;
  return has_frame_number(name) && !std::filesystem::exists(name, error);
}

std::vector<int> existing_frames(const std::string& name) {
  const std::filesystem::path path(name);
  if (has_frame_number(path.parent_path().string())) {
    throw UsageError("{}: only the file's name may have a frame number, not its folder", name);
  }
  const std::string pattern = path.filename().string();
  const size_t digits = pattern.find('#');
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::vector<int> frames;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string file = entry->path().filename().string();
    if (file.size() <= digits || file.compare(0, digits, pattern, 0, digits) != 0) continue;
    int frame = 0;
    const auto [rest, fault] =
        std::from_chars(file.data() + digits, file.data() + file.size(), frame);
    if (fault != std::errc() || expand_frame_number(pattern, frame) != file) continue;
    if (frame < -kLastFrame || frame > kLastFrame) continue;
    frames.push_back(frame);
    if (frames.size() > kMaxFrames) throw InputError(name, "more than {} frames", kMaxFrames);
  }
  if (error) throw InputError(name, "cannot list the folder: {}", error.message());
  if (frames.empty()) throw InputError(name, "there is no file with such a name");
  std::ranges::sort(frames);
  return frames;
}

std::vector<int> requested_frames(const RenderOptions& options) {
  std::vector<int> frames = options.frames;
  if (frames.empty() && options.turntable && !options.turntable->frame && !options.frame) {
    for (uint32_t i = 1; i <= options.turntable->count; ++i) frames.push_back(int(i));
  }
  if (frames.empty()) return frames;
  check_names(options, frames);
  return frames;
}

void check_output_folders(const RenderOptions& options, int first) {
  if (!options.save_settings.empty()) check_writable(options.save_settings);
  visit_outputs(options, [&](std::string_view option, const std::string& path) {
    const std::string folder = std::filesystem::path(path).parent_path().string();
    if (has_frame_number(folder)) return;  // each frame has its own folder
    // A folder for snapshots may already exist, and with --skip-existing all files of the range may
    // already exist. In both cases, nothing needs to be created in the parent folder.
    const bool may_exist = options.skip_existing || option == "--snapshots";
    const int mode = may_exist ? F_OK : W_OK | X_OK;
    if (::access(folder.empty() ? "." : folder.c_str(), mode) == 0) return;
    check_writable(expand_frame_number(path, first));
  });
}

RenderOptions options_of_frame(const RenderOptions& options, int frame) {
  RenderOptions adjusted = options;
  adjusted.frames.clear();
  adjusted.command_line += fmt::format(" --frames {}", frame);  // the last --frames wins
  visit_outputs(adjusted,
                [&](const char*, std::string& path) { path = expand_frame_number(path, frame); });
  adjusted.reference = expand_frame_number(adjusted.reference, frame);
  if (adjusted.turntable) adjusted.turntable->frame = frame;
  // A turntable shows the scene at rest, unless an animation is requested.
  if (!adjusted.turntable || !adjusted.animation.empty()) adjusted.frame = frame;
  return adjusted;
}

}  // namespace emberline
