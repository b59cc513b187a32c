"""Simulates a scene as a file has it, and writes what `Run.save` writes: SCENE FOLDER [CHANGE ...]."""

import sys
import warnings

import softpuffer as sp

scene, folder, *changes = sys.argv[1:]
warnings.simplefilter("ignore")
run = sp.load(scene, set=changes).simulate(progress=False, unusable="return")
run.save(folder)
