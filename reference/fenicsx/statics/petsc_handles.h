// PETSc's objects with an owner, and its error codes as exceptions.
#pragma once

#include <petscksp.h>

#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace palpate::reference::fenicsx {

/// Throws std::runtime_error, naming `what`, unless `code` is 0.
inline void check(PetscErrorCode code, const char* what) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw std::runtime_error(std::string(what) + ": PETSc error " + std::to_string(code) +
                           (text != nullptr ? std::string(", ") + text : std::string()));
}

/// Owns one PETSc object; `kDestroy` is its destructor.
template <typename Object, PetscErrorCode (*kDestroy)(Object*)>
class Handle {
 public:
  Handle() = default;
  explicit Handle(Object object) : object_(object) {}
  ~Handle() { kDestroy(&object_); }
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  Object get() const { return object_; }
  Object* put() { return &object_; }  ///< for functions that create an object; it must be empty
  explicit operator bool() const { return object_ != nullptr; }

 private:
  Object object_ = nullptr;
};

using Matrix = Handle<Mat, MatDestroy>;
using Vector = Handle<Vec, VecDestroy>;
using Solver = Handle<KSP, KSPDestroy>;
using NullSpace = Handle<MatNullSpace, MatNullSpaceDestroy>;

/// The entries of a vector on this process, owned ones and then ghosts, while it lives. PETSc learns at its
/// end that they may have changed: norms that it remembers are then dropped.
class LocalEntries {
 public:
  explicit LocalEntries(Vec vector) : vector_(vector) {
    check(VecGhostGetLocalForm(vector_, &local_), "VecGhostGetLocalForm");
    PetscInt count = 0;
    check(VecGetLocalSize(local_, &count), "VecGetLocalSize");
    PetscScalar* data = nullptr;
    check(VecGetArray(local_, &data), "VecGetArray");
    entries_ = {data, static_cast<std::size_t>(count)};
  }
  ~LocalEntries() {
    PetscScalar* data = entries_.data();
    VecRestoreArray(local_, &data);
    VecGhostRestoreLocalForm(vector_, &local_);
  }
  LocalEntries(const LocalEntries&) = delete;
  LocalEntries& operator=(const LocalEntries&) = delete;

  std::span<PetscScalar> get() const { return entries_; }
  PetscScalar& operator[](std::size_t i) const { return entries_[i]; }

 private:
  Vec vector_ = nullptr;
  Vec local_ = nullptr;
  std::span<PetscScalar> entries_;
};

/// A vector like `vector`, of zeros.
inline Vector zeros_like(const Vector& vector) {
  Vector made;
  check(VecDuplicate(vector.get(), made.put()), "VecDuplicate");
  check(VecZeroEntries(made.get()), "VecZeroEntries");
  return made;
}

/// Ghosts take the owner's values.
inline void update_ghosts(const Vector& vector) {
  check(VecGhostUpdateBegin(vector.get(), INSERT_VALUES, SCATTER_FORWARD), "VecGhostUpdate");
  check(VecGhostUpdateEnd(vector.get(), INSERT_VALUES, SCATTER_FORWARD), "VecGhostUpdate");
}

/// The owner's values become the sum over all processes.
inline void add_up_ghosts(const Vector& vector) {
  check(VecGhostUpdateBegin(vector.get(), ADD_VALUES, SCATTER_REVERSE), "VecGhostUpdate");
  check(VecGhostUpdateEnd(vector.get(), ADD_VALUES, SCATTER_REVERSE), "VecGhostUpdate");
}

}  // namespace palpate::reference::fenicsx
