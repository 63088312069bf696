"""Calibration files: one module for each format."""
