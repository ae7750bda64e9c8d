#include "renderer/app/farm/scripts.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <set>

#include "io/files/fingerprint.h"
#include "io/gltf/scene_files.h"
#include "renderer/core/errors.h"
#include "renderer/core/shell_quote.h"
#include "renderer/core/version.h"
#include "renderer/statistics/colour_map.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

// Copies the scene to the stage, a folder on this machine's own disk. "mv -T" renames the copy
// atomically. If other users may write to the parent folder, the script's function safe() requires
// the folder's sticky bit, which keeps them from replacing the stage.
constexpr const char* kStageBegin = R"sh(
# A copy of the scene on this machine's own disk, named after its content. If two parts start at
# once, both copy, and one copy gets the name. A file that has changed meanwhile is not copied. A
# stage that is a link, belongs to another user or lacks a file is not read.
folder=${{TMPDIR:-/tmp}}
stage=$folder/emberline-$(id -u)-{}
each() {{
{}  :
}}
same() {{ [ "$(stat -L -c '%s %.9Y' -- "$1")" = "$3" ]; }}
take() {{ same "$@" && cp -- "$1" "$copy/$2" && same "$@"; }}
kept() {{ [ -f "$stage/$2" ] && [ "$(stat -c %s -- "$stage/$2")" = "${{3%% *}}" ]; }}
safe() {{
  [ -n "$(find -L "$1/." -prune \( -user 0 -o -user "$(id -u)" \) \( -perm -1000 -o ! -perm /022 \))" ]
}}
own() {{ [ -d "$1" ] && [ -O "$1" ] && [ ! -L "$1" ]; }}
if [ ! -e "$stage" ] && [ ! -L "$stage" ]; then
  copy=$(mktemp -d "$stage.XXXXXX") &&
)sh";

constexpr const char* kStageEnd = R"sh(    each take &&
    mv -T "$copy" "$stage" 2>/dev/null
  [ -z "$copy" ] || rm -rf "$copy"
fi
if safe "$folder" && own "$stage" && each kept; then
{}else
  echo "emberline: there is no complete copy of the scene on this machine; the original is used" >&2
fi
)sh";

std::string quoted_option(const char* option, const std::string& value) {
  return value.empty() ? "" : fmt::format(" {} {}", option, shell_quoted(value));
}

std::string style_arguments(const HeatmapStyle& style) {
  std::string words;
  for (const ColourMapEntry& entry : colour_map_table()) {
    if (entry.map == style.colours) words += fmt::format(" --colors {}", entry.name);
  }
  if (style.range) words += fmt::format(" --range={},{}", style.range->min, style.range->max);
  if (style.logarithmic) words += " --log";
  if (style.plain) words += " --plain";
  return words;
}

std::string merge_arguments(const FarmFrame& frame) {
  const RenderOptions& o = frame.options;
  std::string words = shell_quoted(frame.program) + " merge";
  for (const std::string& output : o.outputs) words += quoted_option("-o", output);
  for (const std::string& heatmap : o.heatmaps) words += quoted_option("--heatmap", heatmap);
  for (const std::string& of : o.heatmap_of) words += quoted_option("--heatmap-of", of);
  if (!o.heatmaps.empty()) words += style_arguments(o.heatmap_style);
  words += quoted_option("--display", o.display.display) + quoted_option("--view", o.display.view) +
           quoted_option("--look", o.display.look);
  if (o.display.exposure != 0) words += fmt::format(" --exposure={}", o.display.exposure);
  for (const std::string& report : o.reports) words += quoted_option("--report", report);
  return words + quoted_option("--report", frame.folder.file("merge.json"));
}

// Returns the file's size and the time of its last change in the format of `stat -c '%s %.9Y'`:
// "SIZE SECONDS.NANOSECONDS".
std::string file_state(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  const auto time = error ? fs::file_time_type() : fs::last_write_time(file, error);
  if (error) throw InputError(file.string(), error.message());
  const auto since = std::chrono::file_clock::to_sys(time).time_since_epoch();
  const int64_t ns = std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
  return fmt::format("{} {}.{:09}", size, ns / 1000000000, ns % 1000000000);
}

// Returns the deepest folder that contains all files.
fs::path common_folder(const std::vector<fs::path>& files) {
  fs::path common = files.front().parent_path();
  const auto contains_file = [](const fs::path& folder, const fs::path& file) {
    const fs::path relative = file.lexically_relative(folder);
    return !relative.empty() && *relative.begin() != "..";
  };
  for (const fs::path& file : files) {
    while (!contains_file(common, file) && common != common.parent_path())
      common = common.parent_path();
  }
  return common;
}

// The files to be copied to the scratch folder, and their names in it.
struct Stage {
  std::string folders, files;  // script text: arguments of mkdir; lines of the function each()
  uint64_t hash = 0;

  // Adds a file. Returns its name in the stage as shell text.
  std::string add(const fs::path& source, const fs::path& name) {
    hash = fingerprint(name.string(), hash);
    files += fmt::format("  \"$1\" {} {} '{}' &&\n", shell_quoted(source.string()),
                         shell_quoted(name.string()), file_state(source));
    if (created_folders.insert(name.parent_path()).second) {
      folders += " \"$copy\"/" + shell_quoted(name.parent_path().string());
    }
    return "\"$stage\"/" + shell_quoted(name.string());
  }

 private:
  std::set<fs::path> created_folders;
};

std::string stage_script(const RenderOptions& options) {
  LoadProgress progress({}, {}, limits_of(options.limits, options.scene));
  const std::vector<fs::path> files = scene_files(options.scene, options.resource_root, progress);
  const fs::path folder = common_folder(files);
  Stage stage;
  stage.hash = scene_fingerprint(options.scene, options.resource_root, progress);
  std::string staged;
  for (const fs::path& file : files) {
    const std::string name = stage.add(file, "scene" / file.lexically_relative(folder));
    if (staged.empty()) staged = "  scene=" + name + "\n";
  }
  if (!options.resource_root.empty()) staged += "  root=\"$stage\"/scene\n";
  if (!options.environment.empty()) {
    const fs::path file = options.environment;
    stage.hash = fingerprint(hexadecimal(file_fingerprint(file.string(), progress)), stage.hash);
    staged += "  env=" + stage.add(file, "env" / file.filename()) + "\n";
  }
  return fmt::format(fmt::runtime(kStageBegin), hexadecimal(stage.hash), stage.files) +
         "    mkdir -p" + stage.folders + " &&\n" + fmt::format(fmt::runtime(kStageEnd), staged);
}

// Returns the shell line with which a script opens its log, or "" if Slurm opens the log. Appends
// `suffix` to the log's name, unquoted, so that the shell expands it.
std::string log_line(const FarmFolder& folder, const std::string& name, const std::string& suffix) {
  if (folder.slurm_writes_logs()) return "";
  return "exec >>" + shell_quoted(folder.file("logs/" + name)) + suffix + " 2>&1\n";
}

// `scene` is shell text that names the scene.
std::string part_arguments(const FarmFrame& frame, const std::string& scene,
                           const std::string& part, const std::string& parts) {
  return fmt::format(
      "{} render {} --settings {} -o {} --part {}/{} --resume --progress-file {}{}.json"
      " --verbose",
      shell_quoted(frame.program), scene, shell_quoted(frame.folder.file("settings.json")),
      shell_quoted(frame.folder.output), part, parts,
      shell_quoted(frame.folder.file("progress/part-")), part);
}

}  // namespace

std::string plan_command(const FarmFrame& frame) {
  return fmt::format("{} plan {} --settings {} -o {} --resume --progress-file {} --verbose",
                     shell_quoted(frame.program), shell_quoted(frame.options.scene),
                     shell_quoted(frame.folder.file("settings.json")),
                     shell_quoted(frame.options.plan), shell_quoted(frame.folder.plan_progress()));
}

std::string part_command(const FarmFrame& frame, const std::string& part,
                         const std::string& parts) {
  return part_arguments(frame, shell_quoted(frame.options.scene), part, parts);
}

std::string merge_command(const FarmFrame& frame) {
  return merge_arguments(frame) + " " + shell_quoted(frame.folder.output + ".part-") +
         fmt::format("*-of-{}.checkpoint", frame.parts);
}

std::string plan_script(const FarmFrame& frame) {
  return "#!/bin/sh\n# Decides the sample counts of the frame, before the parts.\n" +
         log_line(frame.folder, "plan.log", "") + "exec " + plan_command(frame) + "\n";
}

std::string part_script(const FarmFrame& frame, bool stage) {
  const RenderOptions& options = frame.options;
  std::string text = fmt::format(
      "#!/bin/sh\n# Renders part K of the frame: sh part.sh K. In a Slurm array, K is the task.\n"
      "part=${{1:-$SLURM_ARRAY_TASK_ID}}\n{}"
      "echo \"part $part of {} on ${{SLURMD_NODENAME:-$(hostname)}}, $(date -u +%FT%TZ)\"\n",
      log_line(frame.folder, "part-", "\"$part\".log"), frame.parts);
  const std::string parts = std::to_string(frame.parts);
  // The script uses exec, so that signals to its process reach the renderer.
  if (!stage) {
    const std::string scene = shell_quoted(options.scene);
    return text + "exec " + part_arguments(frame, scene, "\"$part\"", parts) + "\n";
  }
  text += "scene=" + shell_quoted(options.scene) + "\n";
  std::string extra_arguments;
  if (!options.resource_root.empty()) {
    text += "root=" + shell_quoted(options.resource_root) + "\n";
    extra_arguments += " --resource-root \"$root\"";
  }
  if (!options.environment.empty()) {
    text += "env=" + shell_quoted(options.environment) + "\n";
    extra_arguments += " --env \"$env\"";
  }
  return text + stage_script(options) + "exec " +
         part_arguments(frame, "\"$scene\"", "\"$part\"", parts) + extra_arguments + "\n";
}

// The script names every part, because a pattern could miss files that a network file system shows
// late.
std::string merge_script(const FarmFrame& frame) {
  return fmt::format(
      "#!/bin/sh\n# Merges all parts into the picture.\n{3}"
      "set --\npart=1\nwhile [ $part -le {0} ]; do\n"
      "  set -- \"$@\" {1}\"$part\"-of-{0}.checkpoint\n  part=$((part + 1))\ndone\n"
      "exec {2} \"$@\"\n",
      frame.parts, shell_quoted(frame.folder.output + ".part-"), merge_arguments(frame),
      log_line(frame.folder, "merge.log", ""));
}

}  // namespace emberline
