#include "counting_new.hpp"

#include <cstdlib>
#include <new>

// A file of its own: inlined into code that uses `new`, malloc and free look mismatched to the compiler.

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define DRIVELINE_SANITIZED
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DRIVELINE_SANITIZED
#endif

#ifdef DRIVELINE_SANITIZED

std::optional<std::size_t> driveline::port::allocations_of_this_thread() noexcept {
  return std::nullopt;
}

#else

namespace {

thread_local std::size_t allocations = 0;

}  // namespace

std::optional<std::size_t> driveline::port::allocations_of_this_thread() noexcept {
  return allocations;
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc{};
}

void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

#endif
