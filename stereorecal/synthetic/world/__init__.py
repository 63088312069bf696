"""Worlds: the content of a scene, how the rig moves through it, and what rays see of it."""
