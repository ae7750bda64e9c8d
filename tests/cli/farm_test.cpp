// Tests `emberline farm` without Slurm. PATH has fake versions of sbatch, squeue and scancel, which
// record their arguments. ci/farm.sh tests with a real Slurm.
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

namespace fs = std::filesystem;

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Farm : public CommandTest {
 protected:
  Farm() {
    fs::create_directory(path("bin"));
    // The tools record one argument per line. sbatch also prints a number for each job.
    tool("sbatch",
         "[ \"$1\" = --version ] && exit 0\nprintf '%s\\n' \"$@\" >>\"$TOOLS/sbatch.words\"\n"
         "[ -e \"$TOOLS/refuse\" ] && { echo 'sbatch: error: invalid partition' >&2; exit 1; }\n"
         "echo x >>\"$TOOLS/jobs\"; wc -l <\"$TOOLS/jobs\" | tr -d ' '\n");
    tool("squeue",
         "[ -e \"$TOOLS/queue\" ] || { echo 'slurm_load_jobs error: Invalid job id specified' "
         ">&2; exit 1; }\ncat \"$TOOLS/queue\"\n");
    tool("scancel", "printf '%s\\n' \"$@\" >>\"$TOOLS/scancel.words\"\n");
    tool("sacct", "exit 1\n");
    with_slurm_.environment = {{"PATH", path("bin") + ":/usr/bin:/bin"}, {"TOOLS", path("bin")}};
  }
  void tool(const std::string& name, const std::string& text) {
    write("bin/" + name, "#!/bin/sh\n" + text);
    ::chmod(path("bin/" + name).c_str(), 0755);
  }
  // The frame has nine buckets.
  Words farm(const std::string& output, const Words& more = {}) {
    return Words{"farm",  scene(),         "-o", output,  "--parts", "3", "--size",
                 "24x24", "--bucket-size", "8",  "--spp", "2"} +
           more;
  }
  void submit(const Words& more = {}) { render(farm(path("out.exr"), more), with_slurm_); }
  void render_parts(const Words& parts) {
    for (const std::string& part : parts) {
      render({"render", scene(), "--settings", path("out.exr.farm/settings.json"), "-o",
              path("out.exr"), "--part", part, "--resume"});
    }
  }
  std::string sbatch_words() const { return text_of(path("bin/sbatch.words")); }
  nlohmann::json status() {
    const RunResult result = run({"farm", "status", path("out.exr"), "--json"}, with_slurm_);
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    return nlohmann::json::parse(result.out, nullptr, false);
  }
  static int shell(const std::string& command) { return std::system(command.c_str()); }

  RunOptions with_slurm_;
};

TEST_F(Farm, SubmitsAnArrayAndAMergeThatWaitsForIt) {
  submit({"--partition", "big,small", "--cpus", "4", "--memory", "1G", "--minutes", "90"});
  const std::string folder = path("out.exr.farm");
  EXPECT_EQ(
      sbatch_words(),
      "--parsable\n--job-name=out.exr\n--chdir=" + folder +
          "\n--open-mode=append\n--requeue\n--partition=big,small\n--cpus-per-task=4\n"
          "--mem=1024M\n--time=90\n--array=1-3\n--output=logs/part-%a.log\n--signal=B:TERM@60\n" +
          folder + "/part.sh\n--parsable\n--job-name=out.exr\n--chdir=" + folder +
          "\n--open-mode=append\n--requeue\n--partition=big,small\n--cpus-per-task=4\n"
          "--mem=1024M\n--time=90\n--output=logs/merge.log\n--dependency=afterok:1\n"
          "--kill-on-invalid-dep=yes\n" +
          folder + "/merge.sh\n");
  const nlohmann::json job = read_json("out.exr.farm/job.json");
  EXPECT_EQ(job["arrays"], nlohmann::json({1}));
  EXPECT_EQ(job["merge"], 2);
}

// With any file name, the scripts must produce the same picture as `render`.
TEST_F(Farm, ScriptsQuoteAnyName) {
  int number = 0;
  for (const std::string& name :
       {std::string("plain"), std::string("it's \"quoted\" $HOME `id` $(id)"),
        std::string("two\nlines and 100% \\n"), std::string("-o *; ? [a]"),
        std::string("ends in two\n\n")}) {
    SCOPED_TRACE(name);
    const std::string folder = path(name);
    fs::create_directory(folder);
    fs::copy_file(scene(), folder + "/s ' \n.glb");
    const std::string output = folder + "/shot.####.exr";
    for (const Words& more : {Words{}, Words{"--stage"}}) {
      RunOptions options = with_slurm_;
      options.environment["TMPDIR"] = path("");
      Words words = farm(output, more);
      words[1] = folder + "/s ' \n.glb";
      render(words, options);
      ::setenv("JOB", (output + ".farm").c_str(), 1);
      ::setenv("TMPDIR", path("").c_str(), 1);
      for (int part = 1; part <= 3; ++part) {
        EXPECT_EQ(shell("SLURM_ARRAY_TASK_ID=" + std::to_string(part) +
                        " sh \"$JOB/part.sh\" >\"$JOB/log\" 2>&1"),
                  0)
            << text_of(output + ".farm/log");
      }
      EXPECT_EQ(shell("sh \"$JOB/merge.sh\" >\"$JOB/log\" 2>&1"), 0)
          << text_of(output + ".farm/log");
      ::unsetenv("TMPDIR");
      EXPECT_TRUE(fs::exists(output + ".farm/merge.json"));
      const std::string single = path("single" + std::to_string(number++) + ".exr");
      Words whole = {"render", words[1],        "-o", single,  "--size",
                     "24x24",  "--bucket-size", "8",  "--spp", "2"};
      render(whole);
      EXPECT_EQ(first_difference(read_exr(folder + "/shot.0000.exr"), read_exr(single)), "");
      fs::remove(folder + "/shot.0000.exr");
    }
  }
}

// The name of the report is that of the scene plus a newline. If the script dropped the newline,
// the report would replace the scene.
TEST_F(Farm, AReportKeepsTheNewlinesAtTheEndOfItsName) {
  const std::string report = scene() + "\n";
  submit({"--report", report});
  render_parts({"1/3", "2/3", "3/3"});
  const std::string before = text_of(scene());
  ASSERT_EQ(shell("sh '" + path("out.exr.farm/merge.sh") + "' >'" + path("log") + "' 2>&1"), 0)
      << text_of(path("log"));
  EXPECT_EQ(text_of(scene()), before);
  EXPECT_EQ(text_of(report).substr(0, 1), "{");
}

// job.json cannot record these names, so the jobs could not be cancelled later.
TEST_F(Farm, NamesThatAreNotUtf8AreRefusedBeforeAnyJob) {
  fs::copy_file(scene(), path("caf\xe9.glb"));
  Words odd_scene = farm(path("out.exr"));
  odd_scene[1] = path("caf\xe9.glb");
  for (const Words& words : {odd_scene, odd_scene + Words{"--print"}, farm(path("o\xff.exr")),
                             farm(path("out.exr"), {"--report", path("r\xff.json")}),
                             farm(path("out.exr"), {"--heatmap", path("h\xff.png")}),
                             farm(path("out.exr"), {"--env", path("e\xff.hdr")}),
                             farm(path("out.exr"), {"--camera", "c\xff"})}) {
    expect_failure(words, 2, {"not UTF-8"}, with_slurm_);
  }
  EXPECT_FALSE(fs::exists(path("bin/sbatch.words")));
  EXPECT_FALSE(fs::exists(path("out.exr.farm")));
}

TEST_F(Farm, SubmittedJobsCanBeCancelled) {
  // After the array is submitted, job.json cannot be written any more.
  tool("sbatch",
       "[ \"$1\" = --version ] && exit 0\necho x >>\"$TOOLS/jobs\"\n"
       "rm \"$JOB/job.json\" && mkdir -p \"$JOB/job.json/full\"\nwc -l <\"$TOOLS/jobs\"\n");
  with_slurm_.environment["JOB"] = path("out.exr.farm");
  const RunResult full = run(farm(path("out.exr")), with_slurm_);
  EXPECT_EQ(full.exit_code, 1) << full.describe();
  EXPECT_NE(full.err.find("job.json"), std::string::npos) << full.describe();
  EXPECT_EQ(text_of(path("bin/scancel.words")), "1\n");
  // Now the command is killed after it has submitted the array, while it submits the merge.
  fs::remove_all(path("out.exr.farm"));
  tool("sbatch",
       "[ \"$1\" = --version ] && exit 0\necho x >>\"$TOOLS/jobs\"\n"
       "[ $(wc -l <\"$TOOLS/jobs\") = 3 ] && kill -9 $PPID\nwc -l <\"$TOOLS/jobs\"\n");
  run(farm(path("out.exr")), with_slurm_);
  fs::remove(path("bin/scancel.words"));
  render({"farm", "cancel", path("out.exr")}, with_slurm_);
  EXPECT_EQ(text_of(path("bin/scancel.words")), "2\n");
}

// If another user prepared the folder with links, the jobs must not write through them.
TEST_F(Farm, LinksInAPreparedFolderAreRefused) {
  submit();
  write("bin/queue", "");
  fs::remove(path("bin/sbatch.words"));
  fs::create_directory(path("elsewhere"));
  write("elsewhere/mine", "mine");
  const std::string folder = path("out.exr.farm/");
  for (const std::string name : {"logs", "progress", "logs/part-2.log", "logs/merge.log",
                                 "progress/part-1.json", "merge.json", "part.sh"}) {
    SCOPED_TRACE(name);
    const bool is_folder = name.find_first_of("/.") == std::string::npos;
    const bool there = fs::exists(folder + name);
    if (there) fs::rename(folder + name, path("aside"));
    fs::create_symlink(path(is_folder ? "elsewhere" : "elsewhere/mine"), folder + name);
    for (const Words& words : {farm(path("out.exr")), farm(path("out.exr"), {"--print"}),
                               Words{"farm", "retry", path("out.exr")}}) {
      expect_failure(words, 2, {name, "symbolic link"}, with_slurm_);
    }
    fs::remove(folder + name);
    if (there) fs::rename(path("aside"), folder + name);
  }
  EXPECT_EQ(text_of(path("elsewhere/mine")), "mine");
  EXPECT_EQ(std::distance(fs::directory_iterator(path("elsewhere")), {}), 1);
  EXPECT_FALSE(fs::exists(path("bin/sbatch.words")));
}

class StagedFarm : public Farm {
 protected:
  StagedFarm() {
    fs::create_directory(path("scratch"));
    submit({"--stage"});
  }
  // Renders the first part again and returns its log.
  std::string part() {
    fs::remove(path("out.exr.part-1-of-3.checkpoint"));
    EXPECT_EQ(shell("TMPDIR='" + path("scratch") + "' sh '" + path("out.exr.farm/part.sh") +
                    "' 1 >'" + path("log") + "' 2>&1"),
              0)
        << text_of(path("log"));
    return text_of(path("log"));
  }
  std::string stage() const { return fs::directory_iterator(path("scratch"))->path().string(); }
  static constexpr const char* kShared = "the original is used";
};

TEST_F(StagedFarm, LinksAreNotRead) {
  EXPECT_EQ(part().find(kShared), std::string::npos);
  const std::string checkpoint = text_of(path("out.exr.part-1-of-3.checkpoint"));
  EXPECT_EQ(part().find(kShared), std::string::npos) << "the copy is there, and used again";
  EXPECT_NE(checkpoint.find(stage()), std::string::npos);
  // Replace the copy's folder by a link to another folder of the same owner.
  const std::string name = stage();
  fs::rename(name, path("other"));
  fs::create_directory_symlink(path("other"), name);
  EXPECT_NE(part().find(kShared), std::string::npos);
  EXPECT_EQ(text_of(path("out.exr.part-1-of-3.checkpoint")).find(name), std::string::npos);
  EXPECT_TRUE(fs::is_symlink(name));
  // Nothing may be copied through a dangling link.
  fs::remove(name);
  fs::create_directory_symlink(path("nothing"), name);
  EXPECT_NE(part().find(kShared), std::string::npos);
  EXPECT_FALSE(fs::exists(path("nothing")));
}

TEST_F(StagedFarm, FolderWritableByOthersIsNotRead) {
  part();
  fs::permissions(path("scratch"), fs::perms(0777));
  EXPECT_NE(part().find(kShared), std::string::npos);
  fs::permissions(path("scratch"), fs::perms(01777));
  EXPECT_EQ(part().find(kShared), std::string::npos);
}

TEST_F(StagedFarm, LostOrTruncatedFilesAreReadFromTheSharedScene) {
  part();
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(stage())) {
    if (!entry.is_regular_file()) continue;
    fs::resize_file(entry.path(), 7);
    EXPECT_NE(part().find(kShared), std::string::npos);
    fs::remove(entry.path());
    EXPECT_NE(part().find(kShared), std::string::npos);
  }
}

TEST_F(Farm, PrintsCommandsForOtherQueues) {
  const RunResult result = run(farm(path("out.exr"), {"--print", "--heatmap", path("h.png")}),
                               {.environment = {{"PATH", "/nowhere"}}});
  EXPECT_EQ(result.exit_code, 0) << result.describe();
  const size_t line = result.out.find('\n');
  EXPECT_NE(result.out.find(" --part {part}/{parts} --resume "), std::string::npos) << result.out;
  EXPECT_NE(result.out.find(" merge -o ", line), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("h.png", line), std::string::npos) << result.out;
  EXPECT_EQ(std::ranges::count(result.out, '\n'), 2) << result.out;
  EXPECT_FALSE(fs::exists(path("bin/sbatch.words")));
  expect_failure({"farm", "cancel", path("out.exr")}, 2, {"nothing was submitted"}, with_slurm_);
}

// The parts of an adaptive frame need a plan, so they wait for the job that makes it.
TEST_F(Farm, AnAdaptiveFrameIsPlannedFirst) {
  const Words adaptive = {"--driver", "adaptive", "--spp", "16"};
  submit(adaptive);
  const std::string words = sbatch_words();
  const size_t plan = words.find("plan.sh"), part = words.find("part.sh");
  ASSERT_LT(plan, part);
  EXPECT_NE(words.find("--dependency=afterok:1\n"), std::string::npos) << words;
  EXPECT_NE(words.find("--dependency=afterok:2\n"), std::string::npos) << words;
  write("bin/queue", "");
  EXPECT_EQ(status()["plan"]["done"], 0.0);
  // A running plan reports its progress.
  write("bin/queue", "1||RUNNING|n7|None\n");
  write("out.exr.farm/progress/plan.json",
        R"({"state": "running", "done": 0.25, "samples": 1000, "elapsed_s": 3, "left_s": 9,
            "host": "n7"})");
  EXPECT_EQ(status()["plan"]["done"], 0.25);
  EXPECT_EQ(status()["plan"]["state"], "running");
  fs::remove(path("out.exr.farm/progress/plan.json"));
  write("bin/queue", "");
  // The plan failed: both are submitted again.
  write("bin/sbatch.words", "");
  render({"farm", "retry", path("out.exr")}, with_slurm_);
  EXPECT_NE(sbatch_words().find("plan.sh"), std::string::npos);
  ASSERT_EQ(shell("sh '" + path("out.exr.farm/plan.sh") + "' 2>/dev/null"), 0);
  EXPECT_EQ(status()["plan"]["state"], "done");
  // A plan that fits is kept.
  write("bin/sbatch.words", "");
  render({"farm", "retry", path("out.exr")}, with_slurm_);
  EXPECT_EQ(sbatch_words().find("plan.sh"), std::string::npos);
  EXPECT_NE(sbatch_words().find("part.sh"), std::string::npos);
  render_parts({"1/3", "2/3", "3/3"});
  ASSERT_EQ(shell("sh '" + path("out.exr.farm/merge.sh") + "' 2>/dev/null"), 0);
  render(Words{"render", scene(), "-o", path("single.exr"), "--size", "24x24", "--plan",
               path("out.exr.farm/frame.plan")} +
         adaptive);
  EXPECT_EQ(first_difference(read_exr(path("single.exr")), read_exr(path("out.exr"))), "");
  // If the plan is lost, it is made again. The other parts keep their checkpoints.
  fs::remove(path("out.exr.farm/frame.plan"));
  fs::remove(path("out.exr.farm/merge.json"));
  fs::remove(path("out.exr.part-2-of-3.checkpoint"));
  write("bin/sbatch.words", "");
  render({"farm", "retry", path("out.exr")}, with_slurm_);
  EXPECT_NE(sbatch_words().find("plan.sh"), std::string::npos);
  EXPECT_NE(sbatch_words().find("--array=2\n"), std::string::npos) << sbatch_words();
  ASSERT_EQ(shell("sh '" + path("out.exr.farm/plan.sh") + "' 2>/dev/null"), 0);
  render_parts({"1/3", "2/3", "3/3"});
  // A plan of another frame is refused before anything is submitted.
  write("look.json", R"({"plan": "out.exr.farm/frame.plan"})");
  expect_failure(
      farm(path("other.exr"), adaptive + Words{"--settings", path("look.json"), "--max-spp", "32"}),
      3, {"frame.plan", "another frame"}, with_slurm_);
  const RunResult printed = run(farm(path("new.exr"), adaptive + Words{"--print"}), with_slurm_);
  EXPECT_EQ(printed.out.find(" plan "), printed.out.find(' ')) << printed.describe();
}

TEST_F(Farm, StatusListsEveryPart) {
  submit();
  EXPECT_EQ(status()["parts"][0]["state"], "failed") << "not in the queue, and has said nothing";
  write("bin/queue", "1|1|RUNNING|n7|None\n1|2|PENDING||Resources\n1|3|PENDING||Priority\n");
  write("out.exr.farm/progress/part-1.json",
        R"({"state": "running", "done": 0.25, "samples": 9, "elapsed_s": 10, "left_s": 30,
            "host": "h", "pid": 1, "written": "2026-01-01T00:00:00Z"})");
  const nlohmann::json running = status();
  EXPECT_EQ(running["parts"][0]["state"], "running");
  EXPECT_EQ(running["parts"][0]["node"], "n7");
  EXPECT_EQ(running["parts"][1]["state"], "waiting");
  EXPECT_EQ(running["left_s"], 110.0) << "30 s and twice 40 s on one node";
  write("bin/queue", "");
  write("out.exr.farm/logs/part-1.log", "first\nemberline: error: no memory\x1b[31m\n\n");
  const nlohmann::json failed = status();
  EXPECT_EQ(failed["parts"][0]["state"], "failed");
  EXPECT_EQ(failed["parts"][0]["message"], "emberline: error: no memory\\x1b[31m");
  EXPECT_TRUE(failed["left_s"].is_null());
}

TEST_F(Farm, RetrySubmitsMissingParts) {
  submit();
  render_parts({"1/3", "3/3"});
  fs::resize_file(path("out.exr.part-3-of-3.checkpoint"),
                  fs::file_size(path("out.exr.part-3-of-3.checkpoint")) - 1);
  write("bin/queue", "");
  fs::remove(path("bin/sbatch.words"));
  render({"farm", "retry", path("out.exr")}, with_slurm_);
  EXPECT_NE(sbatch_words().find("--array=2-3\n"), std::string::npos) << sbatch_words();
  EXPECT_NE(sbatch_words().find("--dependency=afterok:3\n"), std::string::npos) << sbatch_words();
  EXPECT_EQ(text_of(path("bin/scancel.words")), "2\n") << "the merge that waits in vain";
  // If a part is still running, the merge must wait for it.
  write("bin/queue", "3|2|RUNNING|n1|None\n");
  fs::remove(path("bin/sbatch.words"));
  render({"farm", "retry", path("out.exr")}, with_slurm_);
  EXPECT_NE(sbatch_words().find("--array=3\n"), std::string::npos) << sbatch_words();
  EXPECT_NE(sbatch_words().find("--dependency=afterok:3_2:5\n"), std::string::npos)
      << sbatch_words();
  expect_failure(farm(path("out.exr")), 1, {"jobs in the queue"}, with_slurm_);
}

// Merging the parts of another frame would produce the picture of that frame.
TEST_F(Farm, PartsOfAnotherFrameAreRefused) {
  write("look.json", R"({"emberline_edits": 1})");
  const Words edits = {"--edits", path("look.json")};
  submit(edits);
  render_parts({"1/3", "2/3", "3/3"});
  write("bin/queue", "");
  fs::remove(path("bin/sbatch.words"));
  const std::string settings = text_of(path("out.exr.farm/settings.json"));
  const Words more = edits + Words{"--spp", "4"};
  for (const Words& print : {Words{}, Words{"--print"}}) {
    expect_failure(farm(path("out.exr"), more + print), 3,
                   {"part-1-of-3.checkpoint", "--spp: 2 (now 4)"}, with_slurm_);
  }
  EXPECT_EQ(text_of(path("out.exr.farm/settings.json")), settings);
  write("look.json", R"( {"emberline_edits": 1})");
  expect_failure({"farm", "retry", path("out.exr")}, 3,
                 {"part-1-of-3.checkpoint", "the file of --edits changed"}, with_slurm_);
  EXPECT_FALSE(fs::exists(path("bin/sbatch.words")));
}

TEST_F(Farm, RetryMergesFinishedParts) {
  submit();
  render_parts({"1/3", "2/3", "3/3"});
  fs::remove(path("bin/sbatch.words"));
  write("bin/queue", "1|2|RUNNING|n1|None\n2|N/A|PENDING||Dependency\n");
  render({"farm", "retry", path("out.exr")}, with_slurm_);
  EXPECT_FALSE(fs::exists(path("bin/sbatch.words"))) << "the merge waits already";
  write("bin/queue", "1|2|RUNNING|n1|None\n");
  render({"farm", "retry", path("out.exr")}, with_slurm_);
  EXPECT_NE(sbatch_words().find("--dependency=afterok:1_2\n"), std::string::npos) << sbatch_words();
  EXPECT_EQ(sbatch_words().find("--array"), std::string::npos) << sbatch_words();
}

TEST_F(Farm, StatusTrustsSlurmAboutTheEnd) {
  submit();
  const std::string progress =
      R"({"state": "running", "done": 0.4, "samples": 9, "elapsed_s": 10, "left_s": 4,
          "host": "h", "pid": 1, "written": "2026-01-01T00:00:00Z"})";
  for (const char* part : {"1", "2"}) {
    write(std::string("out.exr.farm/progress/part-") + part + ".json", progress);
  }
  write("out.exr.farm/logs/part-2.log", "rendering  40.0 %\n");
  write("bin/queue", "");
  tool("sacct", "printf '1_1|COMPLETED\\n1_2|OUT_OF_MEMORY\\n2|COMPLETED\\n'\n");
  const nlohmann::json ended = status();
  EXPECT_EQ(ended["parts"][0]["state"], "done");
  EXPECT_EQ(ended["parts"][1]["state"], "failed");
  EXPECT_EQ(ended["parts"][1]["message"], "OUT_OF_MEMORY: rendering  40.0 %");
  EXPECT_EQ(ended["merge"]["state"], "done");
  // If Slurm does not answer, a part that has reported no progress for a long time may be lost.
  tool("squeue", "exit 1\n");
  EXPECT_EQ(status()["parts"][0]["state"], "running");
  fs::last_write_time(path("out.exr.farm/progress/part-1.json"),
                      fs::file_time_type::clock::now() - std::chrono::minutes(9));
  const nlohmann::json silent = status();
  EXPECT_EQ(silent["parts"][0]["state"], "unknown");
  EXPECT_EQ(silent["parts"][0]["message"].get<std::string>().find("no progress for"), 0u);
  expect_failure(farm(path("out.exr")), 1, {"squeue"}, with_slurm_);
}

TEST_F(Farm, CancelEndsAllJobs) {
  submit();
  render({"farm", "cancel", path("out.exr.farm")}, with_slurm_);
  EXPECT_EQ(text_of(path("bin/scancel.words")), "1\n2\n");
}

TEST_F(Farm, RejectsImpossibleRequests) {
  scene();
  const RunOptions none = {.environment = {{"PATH", "/nowhere"}}};
  expect_failure(farm(path("out.exr")), 1, {"cannot find sbatch", "--print"}, none);
  expect_failure({"farm"}, 2, {"missing argument: scene"});
  expect_failure({"farm", "status"}, 2, {"missing argument: output"});
  expect_failure({"farm", "status", path("out.exr")}, 3, {"job.json"});
  expect_failure({"farm", scene(), "-o", path("out.exr")}, 2, {"--parts"}, with_slurm_);
  expect_failure({"farm", scene(), "--parts", "2"}, 2, {"-o FILE.exr"}, with_slurm_);
  expect_failure({"farm", path("none.glb"), "-o", path("out.exr"), "--parts", "2"}, 3, {"none.glb"},
                 with_slurm_);
  const std::pair<Words, Words> wrong[] = {{{"--parts", "10"}, {"9 buckets"}},
                                           {{"--parts", "0"}, {"1 to 4096"}},
                                           {{"--frames", "1-9"}, {"the only frame is 0"}},
                                           {{"--memory", "much"}, {"8G"}},
                                           {{"--minutes", "1"}, {"2 to"}},
                                           {{"--cpus", "0"}, {"1 to 4096"}},
                                           {{"--partition", "a b"}, {"--partition"}},
                                           {{"--time-limit", "5"}, {"--time-limit"}},
                                           {{"--driver", "bisection"}, {"bucket"}},
                                           {{"-o", path("out.tif")}, {".exr"}}};
  for (const auto& [more, parts] : wrong)
    expect_failure(farm(path("out.exr"), more), 2, parts, with_slurm_);
  expect_failure(farm(path("nowhere/out.exr")), 1, {"nowhere"}, with_slurm_);
  write("bin/refuse", "");
  const RunResult refused = run(farm(path("out.exr")), with_slurm_);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_EQ(refused.err, "emberline: error: sbatch: sbatch: error: invalid partition\n");
}

TEST_F(Farm, HostileFilesGiveOneLineErrors) {
  submit();
  const std::string job = text_of(path("out.exr.farm/job.json"));
  for (const std::string& text :
       {std::string(), std::string("[]"), std::string(1000, '['), job.substr(0, job.size() / 2),
        std::string(R"({"emberline_farm":1,"scene":"s","parts":4e9,"partition":"","cpus":null})"),
        std::string(
            R"({"emberline_farm":1,"scene":"s","parts":2,"partition":"x --wrap=id","cpus":null,
                        "memory_bytes":null,"minutes":null,"arrays":[1],"merge":2})"),
        std::string(R"({"emberline_farm":1,"scene":"s","parts":2,"partition":"","cpus":null,
                        "memory_bytes":null,"minutes":null,"arrays":["1; id"],"merge":2})")}) {
    write("out.exr.farm/job.json", text);
    for (const char* verb : {"status", "cancel", "retry"}) {
      expect_failure({"farm", verb, path("out.exr")}, 3, {"job.json"}, with_slurm_);
    }
  }
  write("out.exr.farm/job.json", job);
  for (const std::string& text : {std::string("{"), std::string(R"({"state": "gone"})"),
                                  std::string(R"({"state":"running","done":9,"samples":-1})")}) {
    write("out.exr.farm/progress/part-2.json", text);
    const RunResult result = run({"farm", "status", path("out.exr")}, with_slurm_);
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    EXPECT_EQ(result.error_lines().size(), 1u) << result.describe();
    EXPECT_NE(result.err.find("part-2.json"), std::string::npos) << result.err;
  }
}

class FarmedRender : public CommandTest {};

TEST_F(FarmedRender, ReportsItsProgress) {
  render(render_words({"--progress-file", path("p.json")}));
  const nlohmann::json json = read_json("p.json");
  EXPECT_EQ(json["state"], "done");
  EXPECT_EQ(json["done"], 1.0);
  EXPECT_EQ(json["samples"], 256);
  run({"render", path("none.glb"), "-o", path("a.exr"), "--progress-file", path("q.json")});
  EXPECT_EQ(read_json("q.json")["state"], "failed");
  const RunResult kept = run(render_words({"--progress-file", path("none/p.json")}));
  EXPECT_EQ(kept.exit_code, 0) << kept.describe();
  EXPECT_NE(kept.err.find("the frame continues without it"), std::string::npos) << kept.err;
  expect_failure(render_words({"--progress-file", scene()}), 2, {"--progress-file"});
}

// Like --resume, `extend` renders damaged tiles of a checkpoint again. If the checkpoint has no
// tiles, `extend` refuses, names the file and writes nothing. tests/farm/extend.py tests this in
// more detail.
TEST_F(FarmedRender, ExtendRendersADamagedBucketAgain) {
  const Words frame = {"--size", "24x24", "--bucket-size", "8", "--resumable"};
  const std::string kept = path("out.exr.checkpoint");
  const auto damage = [&] {
    auto bytes = read_bytes(kept);
    bytes[bytes.size() - 60] = char(bytes[bytes.size() - 60] ^ 1);  // in the last tile or block
    write_bytes(kept, bytes);
  };
  render(render_words(frame + Words{"--spp", "8", "-o", path("whole.exr")}));
  render(render_words(frame + Words{"--spp", "2"}));
  damage();
  const RunResult extended = run({"extend", path("out.exr"), "--spp", "8"});
  EXPECT_EQ(extended.exit_code, 0) << extended.describe();
  EXPECT_NE(extended.err.find(kept + ": the checkpoint is damaged; the lost tiles are"),
            std::string::npos)
      << extended.err;
  EXPECT_EQ(first_difference(read_exr(path("whole.exr")), read_exr(path("out.exr"))), "");
  EXPECT_FALSE(fs::exists(kept + ".next"));
  render(render_words(frame + Words{"--spp", "2", "--driver", "bisection"}));
  damage();
  expect_failure({"extend", path("out.exr"), "--spp", "8", "-q"}, 3, {kept, "damaged"});
}

TEST_F(FarmedRender, TakesItsLimitsFromTheJob) {
  RunOptions job;
  const auto now = std::time(nullptr);
  job.environment = {{"SLURM_MEM_PER_NODE", "1024"},
                     {"SLURM_CPUS_PER_TASK", "1"},
                     {"SLURM_JOB_START_TIME", std::to_string(now - 5)},
                     {"SLURM_JOB_END_TIME", std::to_string(now + 61)}};
  const Words endless = {"render", scene(),  "-o",     path("out.exr"), "--size",   "512x512",
                         "--spp",  "100000", "--part", "1/2",           "--verbose"};
  const RunResult result = run(endless + Words{"--resume"}, job);
  EXPECT_EQ(result.exit_code, 130) << result.describe();
  for (const char* part : {"--memory-limit 768 MiB: three quarters of SLURM_MEM_PER_NODE",
                           "--threads 1: SLURM_CPUS_PER_TASK", "SLURM_JOB_END_TIME"}) {
    EXPECT_NE(result.err.find(part), std::string::npos) << part << "\n" << result.err;
  }
  job.environment["SLURM_JOB_END_TIME"] = std::to_string(now - 100000);  // as from a wrong clock
  job.environment["SLURM_JOB_START_TIME"] = std::to_string(now - 100000 - 61);
  const RunResult wrong = run(endless + Words{"--resume"}, job);
  EXPECT_EQ(wrong.exit_code, 130);
  EXPECT_NE(wrong.err.find("clock"), std::string::npos) << wrong.err;
  job.environment = {
      {"SLURM_MEM_PER_NODE", "x"}, {"SLURM_CPUS_PER_TASK", "-1"}, {"SLURM_JOB_END_TIME", "soon"}};
  render(render_words({"--resume"}), job);
}

}  // namespace
}  // namespace emberline::test
