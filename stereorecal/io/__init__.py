"""Reading and writing: image pairs, calibrations and scene folders."""

from stereorecal.io._about import about as about
from stereorecal.io._atomic import write_text as write_text
from stereorecal.io._pairs import load_pair as load_pair, load_pairs as load_pairs
from stereorecal.io._rig_file import load_rig as load_rig, save_rig as save_rig
from stereorecal.io._scene import gather_scene as gather_scene, load_scene as load_scene, save_scene as save_scene
