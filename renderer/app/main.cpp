#include "renderer/app/command_line.h"

int main(int argc, char** argv) { return emberline::run_program(argc, argv); }
