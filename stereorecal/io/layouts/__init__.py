"""Data sets: one module for each way in which people lay out their recordings."""
