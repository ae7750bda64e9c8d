#include "renderer/app/commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "io/files/atomic_file.h"
#include "io/files/owned_folder.h"
#include "io/files/record_file.h"
#include "io/files/register.h"
#include "io/json/input.h"
#include "renderer/app/farm/folder.h"
#include "renderer/app/farm/scripts.h"
#include "renderer/app/farm/status.h"
#include "renderer/app/standard_output.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/shell_quote.h"
#include "renderer/core/shortened.h"
#include "renderer/core/utf8.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/frame_merge.h"
#include "renderer/output/outputs.h"
#include "renderer/output/plan_pilot.h"
#include "renderer/output/sample_plan_file.h"
#include "renderer/scene/embree_isa.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

// The files that the command and the plan's job write. merge.json is another one, but folders of
// earlier versions do not list it as their own.
constexpr const char* kFolderFiles[] = {
    "settings.json", "plan.sh",  "frame.plan", "frame.plan.checkpoint",
    "part.sh",       "merge.sh", "job.json"};

void check_request(const FarmOptions& o) {
  if (o.frame.scene.empty())
    throw UsageError("farm: missing argument: scene; see emberline farm --help");
  if (o.frame.outputs.empty())
    throw UsageError("farm needs an output: -o FILE.exr (or .png, .jpg)");
  if (o.parts == 0) throw UsageError("farm needs --parts N: how many jobs share the frame");
  if (o.frame.time_limit_s) {
    throw UsageError(
        "--time-limit: a part that stops early leaves a hole; use --minutes to limit the jobs");
  }
  if (o.frame.turntable && !o.frame.turntable->frame) {
    throw UsageError(
        "--turntable: farm renders only one frame; write turntable K/N in a settings file to "
        "choose it");
  }
  if (is_part(o.frame)) throw UsageError("--part, --sample-range: farm chooses them for each job");
  if (!is_partition(o.request.partition)) {
    throw UsageError("--partition: '{}' is not a list of Slurm partitions",
                     shortened(o.request.partition));
  }
}

std::string absolute(const std::string& path) {
  return path.empty() ? path : fs::absolute(path).string();
}

// Makes paths absolute, because the jobs run in another folder. Adds the channels that the heatmaps
// need.
RenderOptions prepare_options(const FarmOptions& farm) {
  RenderOptions o = farm.frame;
  for (std::string* path : {&o.scene, &o.resource_root, &o.environment, &o.edits, &o.plan})
    *path = absolute(*path);
  for (auto* list : {&o.outputs, &o.heatmaps, &o.reports}) {
    for (std::string& path : *list) path = absolute(expand_frame_zero(path));
  }
  for (const HeatmapRequest& heatmap : heatmap_requests(o)) {
    if (!heatmap.quantity->aov) continue;
    const std::string_view name = name_of(aov_table(), *heatmap.quantity->aov);
    o.aovs += (o.aovs.empty() ? "" : ",") + std::string(name);
  }
  if (o.driver == "adaptive" && o.plan.empty()) o.plan = FarmFolder(o.outputs.front()).plan();
  // All nodes must use the same Embree instruction set, because a merge rejects parts with
  // different instruction sets.
  o.isa = o.isa.value_or(widest_isa());
  return o;
}

bool is_utf8(std::string_view text) {
  while (const size_t length = utf8_length(text)) text.remove_prefix(length);
  return text.empty();
}

// Throws UsageError for a name that is not UTF-8. The parts and `farm cancel` read names from
// job.json and settings.json, which can hold only UTF-8.
void check_names(const RenderOptions& o) {
  std::vector<std::string> names = {o.scene,   o.resource_root, o.environment, o.edits,    o.camera,
                                    o.variant, o.animation,     o.catchers,    o.holdouts, o.plan};
  for (const auto* list : {&o.outputs, &o.heatmaps, &o.reports})
    names.insert(names.end(), list->begin(), list->end());
  for (const std::string& name : names) {
    if (!is_utf8(name)) throw UsageError("farm: {}: this name is not UTF-8", name);
  }
}

// Rejects symbolic links in the folder. Another user may have made the folder, and a link could
// redirect what the jobs write.
void check_file_types(const FarmFolder& folder) {
  std::error_code unknown;
  const auto check = [&](const fs::path& path, fs::file_type expected_type) {
    const fs::file_type type = fs::symlink_status(path, unknown).type();
    if (type == fs::file_type::not_found || type == expected_type) return;
    throw UsageError("{}: it is {}; remove it, or choose another output", path.string(),
                     type == fs::file_type::symlink              ? "a symbolic link"
                     : expected_type == fs::file_type::directory ? "not a folder"
                                                                 : "not a regular file");
  };
  for (const char* name : kFolderFiles) check(folder.file(name), fs::file_type::regular);
  check(folder.file("merge.json"), fs::file_type::regular);
  for (const char* name : {"logs", "progress"}) {
    check(folder.file(name), fs::file_type::directory);
    for (const auto& entry : fs::directory_iterator(folder.file(name), unknown))
      check(entry.path(), fs::file_type::regular);
  }
}

// Checks the frame before any job is submitted.
void check_frame(const RenderOptions& options, uint32_t parts) {
  RenderOptions part = options;
  part.part = FramePart{1, parts};
  const RenderPlan plan(part);
  if (parts > plan.buckets()) {
    throw UsageError(
        "--parts {}: the frame has {} buckets of --bucket-size {}; each part needs at least one",
        parts, plan.buckets(), options.bucket_size);
  }
  FileRegister files;
  check_output_paths(options, plan.crop, files);
  const InputFile scene(options.scene);
  for (const auto* list : {&options.outputs, &options.heatmaps, &options.reports}) {
    for (const std::string& path : *list) check_writable(path);
  }
}

std::vector<SlurmTask> require_queued_tasks(const std::vector<uint64_t>& jobs) {
  auto tasks = queued_tasks(jobs);
  if (tasks) return *std::move(tasks);
  throw RenderError("squeue cannot list the jobs; try again when Slurm answers");
}

void reject_running(const FarmFolder& folder) {
  if (!fs::exists(folder.file("job.json"))) return;
  const std::vector<uint64_t> jobs = read_record(folder).jobs();
  if (jobs.empty()) return;
  const std::vector<SlurmTask> tasks = require_queued_tasks(jobs);
  if (tasks.empty()) return;
  throw RenderError(
      "{}: it has jobs in the queue ({} tasks); wait for them, or cancel them with farm cancel",
      folder.path, tasks.size());
}

// Throws InputError unless the file of the setting `plan` exists and fits the frame.
void check_plan(const FrameSettings& settings) {
  RenderOptions options;
  static_cast<FrameSettings&>(options) = settings;
  const LoadLimits limits = limits_of(options.limits, options.scene);
  LoadProgress progress({}, {}, limits);
  const SamplePlanFile plan(options, limits);
  plan.check(
      checkpoint_head(options, RenderPlan(options), {}, input_fingerprints(options, progress)));
}

bool has_valid_plan(const FrameSettings& settings) {
  try {
    check_plan(settings);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

// Throws InputError for a checkpoint with other settings or of an earlier version of the scene. The
// jobs also reject such a checkpoint. But if every part had one, the merge would accept them and
// write the picture of another frame. Returns the number of parts that have a checkpoint.
int check_checkpoints(const FarmFolder& folder, const FrameSettings& settings, uint32_t parts,
                      bool has_plan) {
  RenderOptions options;
  static_cast<FrameSettings&>(options) = settings;
  options.part = FramePart{1, parts};
  const RenderPlan plan(options);
  LoadProgress progress({}, {}, limits_of(options.limits, options.scene));
  FrameSettings inputs = settings;
  if (!has_plan) inputs.plan.clear();  // plan.sh will write it
  const nlohmann::json head =
      checkpoint_head(options, plan, {}, input_fingerprints(inputs, progress));
  int resumable_parts = 0;
  for (uint32_t part = 1; part <= parts; ++part) {
    const std::string path = folder.checkpoint(part, parts);
    check_checkpoint(path, true);
    if (!InputFile::try_open(path)) continue;
    const RecordFile file(path);
    nlohmann::json then = parse_json(file.head(), path);
    // The plan will be made again. If the new plan differs, the parts reject their checkpoints.
    if (!has_plan && then.contains("inputs") && then["inputs"].is_object()) {
      then["inputs"].erase(plan_input_name());
    }
    const auto different = differences(head, then, {"part"});
    if (!file.records().empty() && !different.empty()) {
      throw InputError(
          path, "it belongs to another frame: {}; remove {}.part-*, or choose another output",
          fmt::join(different, "; "), folder.output);
    }
    ++resumable_parts;
  }
  return resumable_parts;
}

// Removes the progress files of earlier jobs, so that they are not mistaken for those of the new
// jobs.
void remove_progress(const FarmFolder& folder, const std::vector<uint32_t>& parts) {
  std::error_code ignored;
  for (const uint32_t part : parts) fs::remove(folder.progress(part), ignored);
  fs::remove(folder.file("merge.json"), ignored);
}

// Whether the pilot of this frame can continue from the checkpoint of an earlier plan job.
bool continues_pilot(const std::string& checkpoint, const FrameSettings& settings) {
  RenderOptions planned;
  static_cast<FrameSettings&>(planned) = settings;
  planned.plan.clear();
  const RenderOptions pilot = pilot_of(planned);
  LoadProgress progress({}, {}, limits_of(pilot.limits, pilot.scene));
  try {
    const RecordFile file(checkpoint);
    const nlohmann::json head =
        checkpoint_head(pilot, RenderPlan(pilot), {}, input_fingerprints(pilot, progress));
    return differences(head, parse_json(file.head(), checkpoint), {}).empty();
  } catch (const InputError&) {
    return false;
  }
}

// Call before the plan is made again.
void remove_plan(const FarmFolder& folder, const FrameSettings& settings) {
  fs::remove(folder.plan());
  std::error_code ignored;
  fs::remove(folder.plan_progress(), ignored);
  const std::string checkpoint = folder.plan_checkpoint();
  if (!continues_pilot(checkpoint, settings)) fs::remove(checkpoint, ignored);
}

std::vector<uint32_t> all_parts(uint32_t count) {
  std::vector<uint32_t> parts(count);
  std::iota(parts.begin(), parts.end(), 1u);
  return parts;
}

void write_folder(const FarmFrame& frame, bool stage) {
  const FarmFolder& folder = frame.folder;
  for (const char* name : {"logs", "progress"}) {
    std::error_code error;
    fs::create_directory(folder.file(name), error);
    if (error) throw RenderError("{}: {}", folder.file(name), error.message());
  }
  remove_progress(folder, all_parts(frame.parts));
  const std::string settings = folder.file("settings.json");
  write_file_atomically(settings, settings_json(frame.options, settings));
  if (frame.options.plan == folder.plan()) {
    write_file_atomically(folder.file("plan.sh"), plan_script(frame));
  }
  write_file_atomically(folder.file("part.sh"), part_script(frame, stage));
  write_file_atomically(folder.file("merge.sh"), merge_script(frame));
}

// Formats part numbers for sbatch, such as "1-3,7".
std::string format_ranges(const std::vector<uint32_t>& parts) {
  std::string text;
  for (size_t i = 0, end = 0; i < parts.size(); i = end) {
    for (end = i + 1; end < parts.size() && parts[end] == parts[end - 1] + 1;) ++end;
    text += fmt::format("{}{}", text.empty() ? "" : ",", parts[i]);
    if (end > i + 1) text += fmt::format("-{}", parts[end - 1]);
  }
  return text;
}

std::string log_argument(const FarmFolder& folder, const std::string& name) {
  return "--output=" + (folder.slurm_writes_logs() ? "logs/" + name : "/dev/null");
}

void write_record(const FarmFolder& folder, const FarmRecord& record) {
  write_file_atomically(folder.file("job.json"), record_json(record));
}

// Submits the parts as a job array. Also submits a merge, which waits for the parts and for
// `others` (unfinished jobs or tasks). With `plan`, submits plan.sh first, and the parts wait for
// it. Rewrites job.json after each submission, so that `farm cancel` finds every submitted job even
// after a crash.
void submit(const FarmFolder& folder, FarmRecord& record, bool plan,
            const std::vector<uint32_t>& parts, const std::vector<std::string>& others) {
  std::vector<std::string> dependencies = others;
  std::vector<uint64_t> submitted;
  write_record(folder, record);  // fails before any job is submitted
  try {
    // A minute before the time limit, the script's process gets a signal and saves its work.
    const std::string signal = "--signal=B:TERM@60";
    if (plan) {
      submitted.push_back(submit_job(record.request, folder.path, "plan.sh",
                                     {log_argument(folder, "plan.log"), signal}));
      record.plan = submitted.back();
      write_record(folder, record);
    }
    if (!parts.empty()) {
      std::vector<std::string> words = {"--array=" + format_ranges(parts),
                                        log_argument(folder, "part-%a.log"), signal};
      if (const auto job = record.plan; job && !fs::exists(folder.plan())) {
        words.push_back(fmt::format("--dependency=afterok:{}", *job));
        words.push_back("--kill-on-invalid-dep=yes");
      }
      submitted.push_back(submit_job(record.request, folder.path, "part.sh", words));
      record.arrays.push_back(submitted.back());
      write_record(folder, record);
      dependencies.push_back(std::to_string(submitted.back()));
    }
    std::vector<std::string> words = {log_argument(folder, "merge.log")};
    if (!dependencies.empty()) {
      words.push_back(fmt::format("--dependency=afterok:{}", fmt::join(dependencies, ":")));
      words.push_back("--kill-on-invalid-dep=yes");
    }
    submitted.push_back(submit_job(record.request, folder.path, "merge.sh", words));
    record.merge = submitted.back();
    write_record(folder, record);
  } catch (const std::exception&) {
    cancel_jobs(submitted);
    throw;
  }
  if (parts.empty()) return log_info(fmt::format("submitted the merge as job {}", *record.merge));
  log_info(fmt::format("submitted {}{} parts as job {}, and the merge as job {}",
                       plan ? fmt::format("the plan as job {}, ", *record.plan) : "", parts.size(),
                       record.arrays.back(), *record.merge));
}

std::string executable_path() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) throw RenderError("/proc/self/exe: {}", error.message());
  return program.string();
}

int submit_frame(const FarmOptions& farm) {
  check_request(farm);
  const FarmFrame frame{prepare_options(farm), FarmFolder(farm.frame.outputs.front()), farm.parts,
                        executable_path()};
  check_names(frame.options);
  check_frame(frame.options, frame.parts);
  const FarmFolder& folder = frame.folder;
  const bool makes_plan = frame.options.plan == folder.plan();
  if (!frame.options.plan.empty() && !makes_plan) check_plan(frame.options);
  if (!farm.print) require_slurm();
  OwnedFolder owned(folder.path,
                    {.option = "-o", .marker = "emberline-farm.json", .exclusive = true});
  check_file_types(folder);
  reject_running(folder);
  owned.claim(std::vector<std::string>(std::begin(kFolderFiles), std::end(kFolderFiles)));
  const bool has_plan = makes_plan && has_valid_plan(frame.options);
  const int resumable_parts =
      check_checkpoints(folder, frame.options, frame.parts, has_plan || !makes_plan);
  if (makes_plan && !has_plan) remove_plan(folder, frame.options);
  write_folder(frame, farm.stage);
  FarmRecord record;
  record.scene = frame.options.scene;
  record.parts = frame.parts;
  record.request = farm.request;
  record.makes_plan = makes_plan;
  if (farm.print) {
    write_record(folder, record);
    const std::string script = "sh " + shell_quoted(folder.file("part.sh")) + " {part}";
    print_result((makes_plan && !has_plan ? plan_command(frame) + "\n" : "") +
                 (farm.stage ? script : part_command(frame, "{part}", "{parts}")) + "\n" +
                 merge_command(frame) + "\n");
    log_info(
        folder.path +
        " has the scripts of these commands; without --print, this command submits them to Slurm");
    return kExitDone;
  }
  if (resumable_parts > 0) {
    log_info(fmt::format("{} of the parts continue from their checkpoints", resumable_parts));
  }
  submit(folder, record, makes_plan && !has_plan, all_parts(frame.parts), {});
  return kExitDone;
}

bool is_complete_part(const FarmFolder& folder, uint32_t part, uint32_t parts) {
  try {
    return StoredFrame(folder.checkpoint(part, parts)).is_complete_part({part, parts});
  } catch (const InputError&) {
    return false;
  }
}

// Submits the parts that are neither complete nor queued nor running. The new merge also waits for
// the parts that are queued or running.
int retry_frame(const FarmFolder& folder) {
  FarmRecord record = read_record(folder);
  check_file_types(folder);
  require_slurm();
  FrameSettings settings;
  read_settings(folder.file("settings.json"), settings);
  settings.scene = record.scene;
  // Reads the queue before it checks for the plan's file. If the plan job ends in between, its file
  // exists by then.
  const std::vector<SlurmTask> tasks = require_queued_tasks(record.jobs());
  const bool has_plan = record.makes_plan && has_valid_plan(settings);
  check_checkpoints(folder, settings, record.parts, has_plan || !record.makes_plan);
  bool is_merge_queued = false, is_plan_queued = false;
  std::set<uint32_t> queued_parts;
  std::vector<std::string> others;
  for (const SlurmTask& task : tasks) {
    is_merge_queued |= record.merge == task.job;
    is_plan_queued |= record.plan == task.job;
    if (!task.task || !queued_parts.insert(*task.task).second) continue;
    others.push_back(task.id());
  }
  std::vector<uint32_t> missing_parts;
  for (const uint32_t part : all_parts(record.parts)) {
    if (!queued_parts.contains(part) && !is_complete_part(folder, part, record.parts))
      missing_parts.push_back(part);
  }
  const bool merged = queued_parts.empty() && fs::exists(folder.file("merge.json"));
  if (missing_parts.empty() && (merged || is_merge_queued)) {
    log_info(merged ? "all parts are finished and merged"
             : queued_parts.empty()
                 ? "all parts are finished; the merge is waiting or running"
                 : fmt::format("all parts are finished except {} that are waiting or running",
                               queued_parts.size()));
    return kExitDone;
  }
  if (record.merge) cancel_jobs(std::span(&*record.merge, 1));
  remove_progress(folder, missing_parts);
  const bool needs_plan =
      record.makes_plan && !has_plan && !is_plan_queued && !missing_parts.empty();
  if (needs_plan) remove_plan(folder, settings);
  submit(folder, record, needs_plan, missing_parts, others);
  return kExitDone;
}

int cancel_frame(const FarmFolder& folder) {
  const std::vector<uint64_t> jobs = read_record(folder).jobs();
  if (jobs.empty())
    throw UsageError("{}: there are no jobs to cancel: nothing was submitted to Slurm",
                     folder.path);
  cancel_jobs(jobs);
  log_info(fmt::format("cancelled jobs {}; finished work is kept, and farm retry continues from it",
                       fmt::join(jobs, ", ")));
  return kExitDone;
}

}  // namespace

int run_farm(const FarmOptions& options) {
  if (options.verb == FarmVerb::kSubmit) return submit_frame(options);
  if (!options.frame.scene.empty() || !options.frame.outputs.empty()) {
    throw UsageError("farm status, cancel and retry take only the output");
  }
  const FarmFolder folder(options.output);
  if (options.verb == FarmVerb::kCancel) return cancel_frame(folder);
  if (options.verb == FarmVerb::kRetry) return retry_frame(folder);
  const FarmStatus status = farm_status(folder);
  print_result(options.json ? status_json(status) : status_text(status));
  return kExitDone;
}

}  // namespace emberline
