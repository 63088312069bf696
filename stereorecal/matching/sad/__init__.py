"""Block matching by sums of absolute differences, in JAX."""

from stereorecal.matching.sad._sad import SAD as SAD
