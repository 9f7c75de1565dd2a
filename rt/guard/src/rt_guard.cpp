#include "driveline/rt_guard/rt_guard.hpp"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <cstddef>

#if defined(__has_feature)
#define DRIVELINE_HAS_FEATURE(feature) __has_feature(feature)
#else
#define DRIVELINE_HAS_FEATURE(feature) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || DRIVELINE_HAS_FEATURE(address_sanitizer) || \
    DRIVELINE_HAS_FEATURE(thread_sanitizer)
#define DRIVELINE_RT_GUARD_AVAILABLE 0
#else
#define DRIVELINE_RT_GUARD_AVAILABLE 1
#endif

namespace {

using driveline::rt::RtGuard;

// Thread-local variables of the executable itself are plain memory: the first access allocates nothing.
constinit thread_local bool t_armed = false;
constinit thread_local RtGuard::Counts t_counts{};

}  // namespace

namespace driveline::rt {

bool RtGuard::available() noexcept {
  return DRIVELINE_RT_GUARD_AVAILABLE != 0;
}

void RtGuard::enter() noexcept {
  t_counts = {};
  t_armed = true;
}

RtGuard::Counts RtGuard::leave() noexcept {
  t_armed = false;
  return t_counts;
}

RtGuard::Counts RtGuard::counts() noexcept {
  return t_counts;
}

RtGuard::Watch::Watch() noexcept : nested_(t_armed), before_(nested_ ? t_counts.total() : 0) {
  if (!nested_) enter();
}

RtGuard::Watch::~Watch() {
  if (!nested_) leave();
}

std::uint64_t RtGuard::Watch::total() const noexcept {
  return t_counts.total() - before_;
}

}  // namespace driveline::rt

#if DRIVELINE_RT_GUARD_AVAILABLE

extern "C" {

/// Every count passes through here, so a breakpoint here stops at each counted call.
[[gnu::noinline]] void driveline_rt_guard_hit(std::uint64_t* counter) {
  ++*counter;
}

// The internal names of glibc's allocator.
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming) the names are those of glibc
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* block, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);
void __libc_free(void* block);
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)
}

namespace {

void count(std::uint64_t& counter) {
  if (t_armed) {
    driveline_rt_guard_hit(&counter);
  }
}

/// Returns the libc function that our replacement hides, looked up on first use (possibly before any constructor has
/// run).
template <typename Function>
Function next(std::atomic<Function>& cached, const char* name) {
  Function function = cached.load(std::memory_order_relaxed);
  if (function == nullptr) {
    function = reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
    cached.store(function, std::memory_order_relaxed);
  }
  return function;
}

using MutexLock = int (*)(pthread_mutex_t*);
using RwLock = int (*)(pthread_rwlock_t*);
constinit std::atomic<MutexLock> g_mutex_lock{nullptr};
constinit std::atomic<RwLock> g_read_lock{nullptr};
constinit std::atomic<RwLock> g_write_lock{nullptr};

void* allocate_aligned(std::size_t alignment, std::size_t bytes) {
  count(t_counts.allocations);
  return __libc_memalign(alignment, bytes);
}

}  // namespace

extern "C" {

void* malloc(std::size_t bytes) noexcept {
  count(t_counts.allocations);
  return __libc_malloc(bytes);
}

void* calloc(std::size_t number, std::size_t bytes) noexcept {
  count(t_counts.allocations);
  return __libc_calloc(number, bytes);
}

void* realloc(void* block, std::size_t bytes) noexcept {
  count(t_counts.allocations);
  return __libc_realloc(block, bytes);
}

void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  return allocate_aligned(alignment, bytes);
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  return allocate_aligned(alignment, bytes);
}

int posix_memalign(void** block, std::size_t alignment, std::size_t bytes) noexcept {
  if (alignment < sizeof(void*) || (alignment & (alignment - 1)) != 0) {
    return EINVAL;
  }
  void* const result = allocate_aligned(alignment, bytes);
  if (result == nullptr) {
    return ENOMEM;
  }
  *block = result;
  return 0;
}

void free(void* block) noexcept {
  if (block != nullptr) {
    count(t_counts.frees);
  }
  __libc_free(block);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  count(t_counts.locks);
  return next(g_mutex_lock, "pthread_mutex_lock")(mutex);
}

int pthread_rwlock_rdlock(pthread_rwlock_t* lock) noexcept {
  count(t_counts.locks);
  return next(g_read_lock, "pthread_rwlock_rdlock")(lock);
}

int pthread_rwlock_wrlock(pthread_rwlock_t* lock) noexcept {
  count(t_counts.locks);
  return next(g_write_lock, "pthread_rwlock_wrlock")(lock);
}
}

#endif
