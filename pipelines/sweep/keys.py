"""All keys of sweep.toml: what the program checks a file by, and its schema and table are made of."""

KINDS = ("grid", "list", "latin")
# Keys of the file, with the type of the value and what it means.
KEYS = {
    "puffer": (str, "version that the file was written for, as \"0.1\"; a later one is refused"),
    "kind": (str, "how the values of the parameters make cases: \"grid\", all with all; \"list\", the first of each, "
             "then the second, and so on; \"latin\", a Latin hypercube"),
    "cases": (int, "number of cases of a Latin hypercube"),
    "seed": (int, "what the chance of a Latin hypercube begins with (0)"),
    "simulate": (str, "the scene that every case runs (\"sim.toml\")"),
    "optimize": (str, "in its place, the design that every case runs"),
    "model": (str, "the model (\"model.toml\", \"model.geo\" [mm] or \"model.step\")"),
    "mesh": (str, "settings of the mesh (\"cad2fem.toml\")"),
    "tags": (str, "selections (\"tags.toml\")"),
    "body": (str, "of a scene with several bodies, the one that is swept; the others stay as the scene names them"),
    "inside": (list, "patches of the model that lie inside the body"),
    "threads": (int, "cores of a case (1)"),
    "memory_mb": (int, "memory that a cluster is asked for [MB]"),
    "minutes": ((int, float), "longest time of a case; what takes longer has failed (1440) [min]"),
    "picture": (str, "options of `cad2fem picture` for the small pictures; with `--range` they share one scale"),
    "parameters": (dict, "what varies, a table for each"),
}
NEEDED = ("kind", "parameters")
# The same of each [parameters.NAME].
PARAMETER_KEYS = {
    "file": (str, "the file in which the value goes: that of the model, mesh, tags, scene or design"),
    "set": ((str, list), "its key there, such as \"chamber.cavity.pressure\", or a list of keys"),
    "value": (None, "the same for all cases"),
    "values": (list, "a list of numbers or texts; a Latin hypercube gives each as often"),
    "from": ((int, float), "the first of numbers between two"),
    "to": ((int, float), "the last of them"),
    "count": (int, "how many there are; not for a Latin hypercube"),
    "scale": (str, "\"log\": by equal factors (\"linear\")"),
    "unit": (str, "written beside the name"),
}
PARAMETER_NEEDED = ("file", "set")
# Columns that the table of cases has besides the parameters and the numbers of reports.
COLUMNS = ("case", "status", "failure", "seconds", "folder")
# Options of `cad2fem picture` that a sweep may give, and whether a value follows. None names a file.
LOOKS = {
    "--view": True, "--orthographic": False, "--cut": True, "--color": True, "--range": True,
    "--deform": True, "--magnify": True, "--edges": False, "--smooth": False, "--no-ground": False, "--title": True,
}
