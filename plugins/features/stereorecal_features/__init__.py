"""SIFT features and an essential matrix: the classical, feature-based calibration as a stereorecal strategy."""

from stereorecal_features._features import Features as Features
