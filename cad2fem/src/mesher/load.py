import importlib
import importlib.util
import os
import sys


def load(package):
    """A package; of pytetwild, whose own imports need PyVista, its compiled module alone."""
    if package != "pytetwild":
        return importlib.import_module(package)
    folder = importlib.util.find_spec(package).submodule_search_locations[0]
    if sys.platform == "win32":
        os.add_dll_directory(f"{folder}.libs")
    sys.path.append(folder)
    return importlib.import_module("PyfTetWildWrapper")


