"""What is everywhere in a scene: ground, road, water, sky."""
