// What is wrong with a glTF file, kept until it is known whether the picture needs it.
//
// The rule: a fault in what the picture needs ends the load. One in what it does not need, or in an
// optional extension, is a warning. So a check that finds an object broken notes that here, who
// needs the object asks with require(), and what nobody asked for is warned of at the end.
#pragma once

#include <deque>
#include <initializer_list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/core/memory_budget.h"

namespace emberline {

// Thread-safe. What is noted is reserved from the budget: a file may have a million faults.
class GltfFaults {
 public:
  explicit GltfFaults(std::shared_ptr<MemoryBudget> budget)
      : memory_(std::move(budget), MemoryPart::kFile) {}

  // A fault that has been noted before. What is broken because something else is, is not warned of
  // a second time.
  struct Known : InputError {
    explicit Known(const InputError& fault) : InputError(fault) {}
  };

  // Called where an error is caught: throws it on if it is a LimitError, which is nobody's fault.
  // Those below do so as well.
  static void let_limits_pass(const InputError& caught);

  // The object at `pointer` ("/cameras/3") cannot be used. Its first fault counts.
  void note(const std::string& pointer, const InputError& fault) { add(pointer, fault, false); }
  // What stands at `pointer` has a default, which takes its place whoever needs it.
  void leave_out(const std::string& pointer, const InputError& fault) { add(pointer, fault, true); }

  bool has(const std::string& pointer) const;
  // Throws Known if something of `pointer` was noted or left out.
  void require(const std::string& pointer) const;
  // The fault of the object, which is not warned of here any more: somebody else does.
  std::optional<InputError> hand_over(const std::string& pointer);

  // How many there are; and forgets all but the first so many: those of a pose, when the next is
  // made.
  size_t count() const;
  void forget(size_t count);

  // A line for each kind of place, in the order in which they were found: the first of them, and
  // how many more there are.
  std::vector<std::string> lines() const;
  // The first fault in these parts of the document ("/meshes/") that lines() has; not one in an
  // extension, which has a default.
  std::optional<std::string> first_below(std::initializer_list<std::string_view> parts) const;

 private:
  struct Fault {
    std::string pointer;
    InputError error;
    bool left_out, told;
  };
  void add(const std::string& pointer, const InputError& fault, bool left_out);

  mutable std::mutex mutex_;
  std::deque<Fault> faults_;                  // as they were found
  std::map<std::string_view, size_t> found_;  // by their pointers
  MemoryReservation memory_;
};

}  // namespace emberline
