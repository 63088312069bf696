"""COLMAP's features and its bundle adjustment of rigs as a stereorecal strategy."""

from stereorecal_colmap._colmap import Colmap as Colmap
