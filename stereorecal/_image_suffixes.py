"""Endings of image files; nothing here takes time to import."""

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".jp2", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".pnm", ".webp")
