"""Units of columns and curves, and the ones that people read: a pressure in kPa in place of Pa."""

# What a unit is shown in: the factor, and its name.
DAILY = {"m": (1e3, "mm"), "m3": (1e6, "mL"), "m³": (1e6, "mL"), "Pa": (1e-3, "kPa"), "J": (1e3, "mJ"),
         "rad": (57.29577951308232, "°"), "1": (1, "")}
# Ends of names of a group, and their units; the empty end is every name of it.
GROUPS = {
    "chambers": {".pressure": "Pa", ".volume": "m3", ".volume_rest": "m3"},
    "tags": {".max_displacement": "m", ".mean_displacement": "m"},
    "mean_displacement": {"": "m"},
    "energies": {"": "J"},
}
SINGLE = {"seconds": "s", "wall_s": "s", "t": "s", "peak_rss_mb": "MB"}


def daily(name, known):
    """Factor and unit in which a column is shown, by the units that are known for it by its name."""
    unit = known.get(name) or SINGLE.get(name) or grouped(name)
    return DAILY.get(unit, (1, unit or ""))


def grouped(name):
    ends = GROUPS.get(name.split(".")[0], {})
    return next((unit for end, unit in ends.items() if name.endswith(end) and name.count(".") >= 1), None)
