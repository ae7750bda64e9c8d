// This program contains all whole-frame benchmarks, since linking a program takes half a minute.
// The name by which it is called selects the benchmark. build/release/bin has a link for each
// benchmark.
#include <cstdio>
#include <filesystem>
#include <string>

#include "bench/frame_benches.h"

int main(int argc, char** argv) {
  using namespace emberline::bench;
  const std::string called = std::filesystem::path(argv[0]).filename().string();
  const struct {
    const char* name;
    int (*run)(int argc, char** argv);
  } benches[] = {{"adaptive_bench", run_adaptive_bench},
                 {"edits_bench", run_edits_bench},
                 {"frame_bench", run_frame_bench},
                 {"light_groups_bench", run_light_groups_bench},
                 {"progressive_bench", run_progressive_bench},
                 {"view_bench", run_view_bench}};
  for (const auto& bench : benches) {
    if (called == bench.name) return run_program(bench.name, bench.run, argc, argv);
  }
  std::fprintf(stderr, "%s: call it by the name of a benchmark, such as adaptive_bench\n",
               called.c_str());
  return 2;
}
