"""What surrounds the objects of a scene: ground (water or road), sky, daylight."""
