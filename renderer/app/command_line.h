// The command line: subcommands, and what is wrong with one in our words.
#pragma once

namespace emberline {

// Reads the arguments and runs the subcommand; returns its exit code. Throws UsageError for a wrong
// command line and whatever the subcommand throws.
int run_command_line(int argc, char** argv);

// All that main() does: the streams and signals, the command line, and one line for what is thrown.
int run_program(int argc, char** argv);

}  // namespace emberline
