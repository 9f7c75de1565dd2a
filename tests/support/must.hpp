#pragma once

#include <concepts>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace driveline {

/// The sentence of an error, whatever its type.
template <typename Error>
[[nodiscard]] std::string text_of_error(const Error& error) {
  if constexpr (std::is_convertible_v<const Error&, std::string_view>) {
    return std::string(std::string_view(error));
  } else if constexpr (requires { describe(error); }) {
    return std::string(describe(error));
  } else if constexpr (requires { to_text(error); }) {
    return std::string(to_text(error));
  } else if constexpr (requires { std::string(error.message()); }) {
    return std::string(error.message());
  } else if constexpr (requires { std::string(error.message); }) {
    return std::string(error.message);
  } else if constexpr (requires { std::string(error.text); }) {
    return std::string(error.text);
  } else {
    return "an error";
  }
}

/// The sentence of the error of a result; empty: it is a success.
template <typename Result>
[[nodiscard]] std::string failure_text(const Result& result) {
  return result ? std::string{} : text_of_error(result.error());
}

/// Passes a result on that must be a success: otherwise the test fails and ends, with the sentence of the error.
template <typename Result>
[[nodiscard]] Result must(Result result) {
  if constexpr (requires { result.error(); }) {
    if (!result) throw std::runtime_error(text_of_error(result.error()));
  } else {
    if (!result) throw std::runtime_error("there is no value");
  }
  return result;
}

}  // namespace driveline
