# Loads gmsh, or says which Debian packages its shared library needs.
import json
import os
import re
import sys

import numpy

try:
    import gmsh
except ImportError as error:
    print(f"gmsh cannot be loaded ({error}); run `make setup`", file=sys.stderr)
    sys.exit(3)
except OSError as error:
    print(
        f"gmsh cannot be loaded ({error}); on Debian: "
        "apt-get install libglu1-mesa libgl1 libgomp1 libxft2 libxcursor1 libxinerama1 libxrender1",
        file=sys.stderr,
    )
    sys.exit(3)


def explain(message):
    print(message, file=sys.stderr)
    sys.exit(3)


def note(message):
    """Tells the person who waits."""
    with open("notes", "a") as notes:
        print(message, file=notes)


settings = json.load(open("settings.json"))
