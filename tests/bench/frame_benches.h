// The benchmarks of frame_benches.cpp.
#pragma once

#include "bench/bench_frame.h"

namespace emberline::bench {

int run_adaptive_bench(int argc, char** argv);
int run_edits_bench(int argc, char** argv);
int run_frame_bench(int argc, char** argv);
int run_light_groups_bench(int argc, char** argv);
int run_progressive_bench(int argc, char** argv);
int run_view_bench(int argc, char** argv);

}  // namespace emberline::bench
