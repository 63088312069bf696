"""Rendering: textures, lit patches, ray casting onto them, and the sensor that turns radiance into grey levels."""
