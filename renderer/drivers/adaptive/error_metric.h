// In what units an error counts. Each metric weighs a channel's squared error by a function of the
// channel's value; expected errors are sums of weight x variance. The weight is 1 for mse,
// 1 / (mean^2 + epsilon) for relmse (rel_mse_epsilon()), display_error_weight() for display, and
// for denoised, where the errors are those that a filter leaves (denoised_error.h).
#pragma once

#include <span>

#include "renderer/core/display_error.h"
#include "renderer/core/names.h"
#include "renderer/drivers/driver_choices.h"

namespace emberline {

// The table behind --allocation, its --help and its error message.
std::span<const NamedValue<ErrorMetric>> error_metric_table();

}  // namespace emberline
