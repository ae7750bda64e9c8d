// Collects the faults in a glTF file until it is known whether the image needs the faulty objects.
//
// A fault in a needed object aborts the load. A fault in an unneeded object or in an optional
// extension causes a warning. A check that finds a broken object calls note_broken(), and code that
// uses the object calls require(). At the end, the faults of all objects that were not required
// become warnings.
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

// Thread-safe. Reserves memory for the faults from the budget, since a file may have a million
// faults.
class GltfFaults {
 public:
  explicit GltfFaults(std::shared_ptr<MemoryBudget> budget)
      : memory_(std::move(budget), MemoryPart::kFile) {}

  // A fault that follows from a fault that has already been noted. It causes no second warning.
  struct KnownFault : InputError {
    explicit KnownFault(const InputError& fault) : InputError(fault) {}
  };

  // Rethrows `caught` if it is a LimitError, which is not a fault of the file. Call it in every
  // handler that catches InputError; note_broken() and note_defaulted() call it themselves.
  static void rethrow_limit_error(const InputError& caught);

  // Marks the object at `pointer` ("/cameras/3") as unusable. Keeps only the object's first fault.
  void note_broken(const std::string& pointer, const InputError& fault) {
    add(pointer, fault, false);
  }
  // Records that a default replaces the value at `pointer`.
  void note_defaulted(const std::string& pointer, const InputError& fault) {
    add(pointer, fault, true);
  }

  bool has(const std::string& pointer) const;
  // Throws KnownFault if a fault was noted at `pointer`.
  void require(const std::string& pointer) const;
  // Returns the object's fault and drops its warning; the caller must report it.
  std::optional<InputError> take_fault(const std::string& pointer);

  // The number of faults. forget() drops all faults but the first `count`, to discard the faults of
  // a pose.
  size_t count() const;
  void forget(size_t count);

  // Returns one line for each kind of location (a JSON pointer without indices), in order of
  // discovery. A line has the first fault of its kind and the number of others.
  std::vector<std::string> lines() const;
  // Returns the first fault of lines() whose pointer begins with one of `parts` ("/meshes/"). Skips
  // faults in extensions, because these have defaults.
  std::optional<std::string> first_fault_below(std::initializer_list<std::string_view> parts) const;

 private:
  struct Fault {
    std::string pointer;
    InputError error;
    bool defaulted, is_reported;
  };
  void add(const std::string& pointer, const InputError& fault, bool defaulted);

  mutable std::mutex mutex_;
  std::deque<Fault> faults_;                  // in order of discovery
  std::map<std::string_view, size_t> found_;  // indices into faults_, by pointer
  MemoryReservation memory_;
};

}  // namespace emberline
