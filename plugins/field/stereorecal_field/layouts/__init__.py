"""Data sets of research on stereo: MODD2, MODS, Middlebury."""
