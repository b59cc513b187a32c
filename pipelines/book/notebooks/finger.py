"""The body of the notebooks: a finger with one chamber above its middle, as a mesh of small blocks."""

import numpy as np

import softpuffer as sp

#: Planes between the blocks across the width x, along the length y and over the height z [m].
PLANES = [np.array([0, 2, 7, 12, 14]) * 1e-3, np.linspace(0, 60, 16) * 1e-3, np.array([0, 3, 8, 10]) * 1e-3]
#: The six tetrahedra of a block, as orders in which a path along its edges takes the axes.
PATHS = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]


def is_air(block):
    """Whether a block belongs to the chamber."""
    x, y, z = block
    return x in (1, 2) and 0 < y < len(PLANES[1]) - 2 and z == 1


def finger() -> sp.Body:
    """The finger: 14 mm wide, 60 mm long and 10 mm high, with the tags `seat`,
    `tip`, `cavity` and `skin`."""
    points = [len(planes) for planes in PLANES]
    tets = []
    for block in np.ndindex(*(count - 1 for count in points)):
        for path in [] if is_air(block) else PATHS:
            corners = [np.array(block)]
            for axis in path:
                corners.append(corners[-1] + np.eye(3, dtype=int)[axis])
            tets.append([np.ravel_multi_index(corner, points) for corner in corners])
    used, tets = np.unique(tets, return_inverse=True)
    tets = tets.reshape(-1, 4)
    vertices = np.stack([planes[k] for planes, k in zip(PLANES, np.unravel_index(used, points))], axis=1)
    # the boundary: facets that belong to one tetrahedron
    facets = np.concatenate([np.delete(tets, corner, axis=1) for corner in range(4)])
    facets, times = np.unique(np.sort(facets, axis=1), axis=0, return_counts=True)
    facets = facets[times == 1]
    low, high = vertices[facets].min(axis=1), vertices[facets].max(axis=1)
    size = vertices.max(axis=0)
    tags = {"seat": high[:, 1] < 1e-9, "tip": low[:, 1] > size[1] - 1e-9}
    tags["cavity"] = np.all((low > 1e-9) & (high < size - 1e-9), axis=1)
    tags["skin"] = ~np.any(list(tags.values()), axis=0)
    return sp.Body(vertices, tets, {name: facets[there] for name, there in tags.items()})
