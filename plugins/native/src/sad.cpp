// The search, compiled for every processor and for those with AVX2; which one runs is decided where it runs.

#include "sad.hpp"

#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#define INLINE __attribute__((always_inline)) inline

namespace stereorecal {
namespace {

constexpr std::int32_t kNever = std::numeric_limits<std::int32_t>::max();

namespace baseline {
constexpr int kBytes = 16;
#include "search.inc"
}  // namespace baseline

// Not a file of its own with flags of its own: its copies of the standard library's functions could replace those of
// the baseline. Not an attribute of one function: GCC lowers vectors before it inlines.
#if defined(__x86_64__)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
namespace avx2 {
constexpr int kBytes = 32;
#include "search.inc"
}  // namespace avx2
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

}  // namespace

void search(const Images& images, const Options& options, const Winners& found) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return avx2::search(images, options, found);
#endif
  baseline::search(images, options, found);
}

}  // namespace stereorecal
