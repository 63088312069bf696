"""Reading and writing: image pairs and scene folders."""

from stereorecal.io._pairs import load_pair as load_pair
from stereorecal.io._pairs import load_pairs as load_pairs
from stereorecal.io._scene import load_scene as load_scene
from stereorecal.io._scene import save_scene as save_scene
