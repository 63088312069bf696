// The search as a custom call of XLA: what stereorecal/matching/sad/_kernel.py says of it.

#include <cstdint>
#include <cstdlib>
#include <exception>

#include "sad.hpp"
#include "xla/ffi/api/ffi.h"

namespace {

namespace ffi = xla::ffi;
using stereorecal::Images;
using stereorecal::Options;
using stereorecal::Winners;

using Image = ffi::Buffer<ffi::S16>;
using Result = ffi::ResultBuffer<ffi::S32>;

ffi::Error Search(Image left, Image right, Result winner, Result cost, Result rivals, Result below, Result above,
                  Result from_right, std::int64_t min_disparity, std::int64_t num_disparities, std::int64_t block_size,
                  std::int64_t uniqueness_ratio, std::int64_t largest_cost) try {
  const auto size = left.dimensions();
  if (size.size() < 2 || !(size == right.dimensions()))
    return ffi::Error::InvalidArgument("not two images of one size");
  const Images first{left.typed_data(), right.typed_data(), size[size.size() - 2], size[size.size() - 1]};
  const std::int64_t end = min_disparity + num_disparities, pixels = first.height * first.width;
  if (num_disparities < 1 || block_size < 1 || std::abs(min_disparity) >= first.width || std::abs(end) >= first.width)
    return ffi::Error::InvalidArgument("the disparities reach beyond the image");
  for (Result* result : {&winner, &cost, &rivals, &below, &above, &from_right})
    if ((*result)->element_count() != left.element_count())
      return ffi::Error::InvalidArgument("results of another size");

  const Options options{min_disparity, num_disparities, block_size, uniqueness_ratio, largest_cost};
  for (std::size_t at = 0; at < left.element_count(); at += pixels) {
    search(Images{first.left + at, first.right + at, first.height, first.width}, options,
           Winners{winner->typed_data() + at, cost->typed_data() + at, rivals->typed_data() + at,
                   below->typed_data() + at, above->typed_data() + at, from_right->typed_data() + at});
  }
  return ffi::Error::Success();
} catch (const std::exception& error) {
  return ffi::Error(ffi::ErrorCode::kResourceExhausted, error.what());
}

}  // namespace

#pragma GCC visibility push(default)
XLA_FFI_DEFINE_HANDLER_SYMBOL(stereorecal_sad_winners, Search,
                              ffi::Ffi::Bind()
                                  .Arg<Image>()
                                  .Arg<Image>()
                                  .Ret<ffi::Buffer<ffi::S32>>()
                                  .Ret<ffi::Buffer<ffi::S32>>()
                                  .Ret<ffi::Buffer<ffi::S32>>()
                                  .Ret<ffi::Buffer<ffi::S32>>()
                                  .Ret<ffi::Buffer<ffi::S32>>()
                                  .Ret<ffi::Buffer<ffi::S32>>()
                                  .Attr<std::int64_t>("min_disparity")
                                  .Attr<std::int64_t>("num_disparities")
                                  .Attr<std::int64_t>("block_size")
                                  .Attr<std::int64_t>("uniqueness_ratio")
                                  .Attr<std::int64_t>("largest_cost"));

extern "C" const int stereorecal_ffi_version = XLA_FFI_API_MINOR;
#pragma GCC visibility pop
