"""SIFT features and an essential matrix: what a vision engineer would try before any search on a stereo score."""

from stereorecal_features._features import Features as Features
