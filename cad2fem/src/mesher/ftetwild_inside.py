# Follows ftetwild.py where surfaces lie inside, whose winding number is not that of the body:
# leaves all tetrahedra of the box around it, of which the caller takes those in the body.
result = mesher.get_tet_mesh(all_mesh=True)
numpy.save("points.npy", numpy.ascontiguousarray(result[0], dtype=float) / scale)
numpy.save("tets.npy", numpy.ascontiguousarray(result[1], dtype=float))
