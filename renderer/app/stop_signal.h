// Ctrl-C and SIGTERM as a request to stop: the first lets the frame write what there is, the
// second ends the process at once.
#pragma once

namespace emberline {

void install_stop_handlers();
bool stop_signalled();

}  // namespace emberline
