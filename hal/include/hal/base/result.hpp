#pragma once
#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace onemap {

// What went wrong in the world: where (file:line, address, device, key) and why. Never for programming errors.
struct Error {
  std::string place;
  std::string reason;
  std::string text() const { return place.empty() ? reason : place + ": " + reason; }
};

// A value or the error that kept it from existing. Handled exactly once: logged and counted, or returned.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }
  T& value() & { return assert(ok()), std::get<0>(state_); }
  const T& value() const& { return assert(ok()), std::get<0>(state_); }
  T&& value() && { return assert(ok()), std::get<0>(std::move(state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  const Error& error() const { return assert(!ok()), std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

// The result of something that is done for its effect.
using Status = Result<std::monostate>;
inline Status success() { return std::monostate{}; }

}  // namespace onemap
