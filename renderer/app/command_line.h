// The command line: subcommands and usage errors.
#pragma once

namespace emberline {

// Reads the arguments and runs the subcommand; returns its exit code. Throws UsageError for a wrong
// command line and passes on what the subcommand throws.
int run_command_line(int argc, char** argv);

// The body of main(): prepares streams and signals, runs the command line and reports exceptions in
// one line.
int run_program(int argc, char** argv);

}  // namespace emberline
