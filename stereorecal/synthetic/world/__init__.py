"""A world: everything there is to see in a scene, how the rig moves through it, and what rays see of it."""
