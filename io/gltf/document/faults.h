// Faults in a glTF file, collected until it is known whether the image needs the faulty objects.
//
// A fault in a needed object aborts the load; a fault in an unneeded one or in an optional
// extension is a warning. A check that finds a broken object calls note(), a user of the object
// calls require(), and faults that were never required are warned about at the end.
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

// Thread-safe. Reserves memory for the faults from the budget, since a file may have a million.
class GltfFaults {
 public:
  explicit GltfFaults(std::shared_ptr<MemoryBudget> budget)
      : memory_(std::move(budget), MemoryPart::kFile) {}

  // A fault that has been noted elsewhere, as the cause of this one; it is not warned about again.
  struct Known : InputError {
    explicit Known(const InputError& fault) : InputError(fault) {}
  };

  // Rethrows `caught` if it is a LimitError, which is not a fault of the file. Call it in every
  // handler; note() and leave_out() call it themselves.
  static void let_limits_pass(const InputError& caught);

  // Marks the object at `pointer` ("/cameras/3") as unusable. Only its first fault is kept.
  void note(const std::string& pointer, const InputError& fault) { add(pointer, fault, false); }
  // Records that the value at `pointer` is replaced by its default.
  void leave_out(const std::string& pointer, const InputError& fault) { add(pointer, fault, true); }

  bool has(const std::string& pointer) const;
  // Throws Known if `pointer` was noted or left out.
  void require(const std::string& pointer) const;
  // Returns the object's fault and drops its warning; the caller reports it.
  std::optional<InputError> hand_over(const std::string& pointer);

  // The number of faults; and drops all after the first `count`, those of the previous pose.
  size_t count() const;
  void forget(size_t count);

  // One line per kind of location, in order of discovery: its first fault and the number of others.
  std::vector<std::string> lines() const;
  // The first fault of lines() below one of these parts of the document ("/meshes/"), except faults
  // in extensions, which have defaults.
  std::optional<std::string> first_below(std::initializer_list<std::string_view> parts) const;

 private:
  struct Fault {
    std::string pointer;
    InputError error;
    bool left_out, told;
  };
  void add(const std::string& pointer, const InputError& fault, bool left_out);

  mutable std::mutex mutex_;
  std::deque<Fault> faults_;                  // in order of discovery
  std::map<std::string_view, size_t> found_;  // indices by pointer
  MemoryReservation memory_;
};

}  // namespace emberline
