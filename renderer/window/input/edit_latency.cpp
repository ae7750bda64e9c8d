#include "renderer/window/input/edit_latency.h"

#include <algorithm>
#include <limits>

namespace emberline {

void EditLatency::add_edit(uint64_t number, std::string what, double time_s) {
  if (edits_.size() >= kMaxEdits) {
    edits_.clear();
    first_unfilled_ = first_incomplete_ = 0;
  }
  edits_.push_back({number, std::move(what), time_s, std::nullopt, std::nullopt});
}

void EditLatency::displayed(const SessionPicture& picture, double time_s) {
  if (!picture.filled) return;
  for (; first_unfilled_ < edits_.size(); ++first_unfilled_) {
    MeasuredEdit& edit = edits_[first_unfilled_];
    if (edit.number > picture.edit) break;
    edit.filled_s = time_s;
    newest_s_ = time_s - edit.input_s;
  }
  if (!picture.complete) return;
  for (; first_incomplete_ < edits_.size(); ++first_incomplete_) {
    MeasuredEdit& edit = edits_[first_incomplete_];
    if (edit.number > picture.edit) break;
    edit.complete_s = time_s;
  }
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::ranges::sort(values);
  const double position = q * double(values.size() - 1);
  const auto below = size_t(position);
  const size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (position - double(below)) * (values[above] - values[below]);
}

}  // namespace emberline
