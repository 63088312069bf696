#pragma once

#include <cstdint>

namespace stereorecal {

// As the options of stereorecal.SAD.
struct Options {
  std::int64_t min_disparity;
  std::int64_t num_disparities;
  std::int64_t block_size;
  std::int64_t uniqueness_ratio;
  std::int64_t largest_cost;  // of any window
};

// Two rectified images of one size, row by row.
struct Images {
  const std::int16_t* left;
  const std::int16_t* right;
  std::int64_t height;
  std::int64_t width;
};

// As stereorecal/matching/sad/_stream.py, of each pixel.
struct Winners {
  std::int32_t* winner;
  std::int32_t* cost;
  std::int32_t* rivals;
  std::int32_t* below;
  std::int32_t* above;
  std::int32_t* from_right;
};

// Throws std::bad_alloc; everything else was checked by the caller.
void search(const Images& images, const Options& options, const Winners& found);

}  // namespace stereorecal
