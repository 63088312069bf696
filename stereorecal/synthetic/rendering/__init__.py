"""How a world becomes an image: textures, patches, rays, sensor."""
