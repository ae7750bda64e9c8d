#include "io/gltf/document/faults.h"

#include <algorithm>
#include <cctype>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

// Returns the pointer without indices and attribute names: "/meshes/*/primitives/*/attributes".
std::string pointer_kind(const std::string& pointer) {
  std::string kind;
  for (size_t at = 0; at < pointer.size();) {
    const size_t end = std::min(pointer.find('/', at + 1), pointer.size());
    const std::string step = pointer.substr(at, end - at);
    const bool number = step.size() > 1 && std::isdigit(static_cast<unsigned char>(step[1]));
    kind += number ? "/*" : step;
    if (step == "/attributes" || step == "/targets") break;
    at = end;
  }
  return kind;
}

}  // namespace

void GltfFaults::rethrow_limit_error(const InputError& caught) {
  if (dynamic_cast<const LimitError*>(&caught))
    throw LimitError(static_cast<const LimitError&>(caught));
}

void GltfFaults::add(const std::string& pointer, const InputError& fault, bool defaulted) {
  rethrow_limit_error(fault);
  const bool is_reported = dynamic_cast<const KnownFault*>(&fault) != nullptr;
  const std::string text = fault.what();
  const std::lock_guard lock(mutex_);
  if (found_.contains(pointer)) return;
  memory_.add(sizeof(Fault) + pointer.size() + text.size() + 100, pointer);
  faults_.push_back({pointer, fault, defaulted, is_reported});
  found_.emplace(faults_.back().pointer, faults_.size() - 1);
}

bool GltfFaults::has(const std::string& pointer) const {
  const std::lock_guard lock(mutex_);
  return found_.contains(pointer);
}

void GltfFaults::require(const std::string& pointer) const {
  const std::lock_guard lock(mutex_);
  const auto found = found_.find(pointer);
  if (found != found_.end()) throw KnownFault(faults_[found->second].error);
}

std::optional<InputError> GltfFaults::take_fault(const std::string& pointer) {
  const std::lock_guard lock(mutex_);
  const auto found = found_.find(pointer);
  if (found == found_.end()) return {};
  faults_[found->second].is_reported = true;
  return faults_[found->second].error;
}

size_t GltfFaults::count() const {
  const std::lock_guard lock(mutex_);
  return faults_.size();
}

void GltfFaults::forget(size_t count) {
  const std::lock_guard lock(mutex_);
  while (faults_.size() > count) {
    found_.erase(faults_.back().pointer);
    faults_.pop_back();
  }
}

std::optional<std::string> GltfFaults::first_fault_below(
    std::initializer_list<std::string_view> parts) const {
  const std::lock_guard lock(mutex_);
  for (const Fault& fault : faults_) {
    const std::string_view pointer = fault.pointer;
    if (fault.is_reported || pointer.find("/extensions/") != pointer.npos) continue;
    const auto is_below = [&](std::string_view part) { return pointer.starts_with(part); };
    if (std::ranges::any_of(parts, is_below)) return fault.error.what();
  }
  return {};
}

std::vector<std::string> GltfFaults::lines() const {
  // The schema tables have fewer kinds of locations than this. Any further kinds would be counted
  // together with the last one.
  constexpr size_t kMaxKinds = 60;
  struct Line {
    std::string kind, text;
    uint64_t more = 0;
  };
  std::vector<Line> lines;
  const std::lock_guard lock(mutex_);
  for (const Fault& fault : faults_) {
    if (fault.is_reported) continue;
    const char* remedy = fault.defaulted ? "; it is left out" : "; it is not used";
    const std::string kind = pointer_kind(fault.pointer) + remedy;
    const auto same = std::ranges::find(lines, kind, &Line::kind);
    if (same != lines.end()) {
      ++same->more;
    } else if (lines.size() == kMaxKinds) {
      ++lines.back().more;
    } else {
      lines.push_back({kind, fault.error.what() + std::string(remedy)});
    }
  }
  std::vector<std::string> texts;
  for (const Line& line : lines) {
    texts.push_back(line.text);
    if (line.more > 0) texts.back() += " (and " + std::to_string(line.more) + " more like it)";
  }
  return texts;
}

}  // namespace emberline
