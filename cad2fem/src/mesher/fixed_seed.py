import ctypes

# fTetWild draws the order in which it inserts triangles from std::random_device and has no seed.
DRAW = b"_ZNSt13random_device9_M_getvalEv"


def fix_seed(library, seed):
    """Replaces std::random_device in a loaded library by rand() of the C library with this seed,
    in its table of imported functions; False where it has none that can be written."""
    try:
        maps = [line.split() for line in open("/proc/self/maps") if line.rstrip().endswith(library)]
    except OSError:
        return False
    if not maps:
        return False
    base = int(maps[0][0].split("-")[0], 16)

    def number(kind, address):
        return kind.from_address(address).value

    def long(address):
        return number(ctypes.c_uint64, address)

    # The header of the library (ELF, 64 bits), the segment of type PT_DYNAMIC, its entries.
    if ctypes.string_at(base, 5) != b"\x7fELF\x02":
        return False
    segments, size = base + long(base + 32), number(ctypes.c_uint16, base + 54)
    count = number(ctypes.c_uint16, base + 56)
    segments = range(segments, segments + size * count, size)
    entry = next(base + long(s + 16) for s in segments if number(ctypes.c_uint32, s) == 2)
    entries = {}
    while long(entry):
        entries[long(entry)] = long(entry + 8)
        entry += 16
    names, symbols, imports = (  # DT_STRTAB, DT_SYMTAB, DT_JMPREL; the loader may have added base
        entries.get(tag, 0) + (0 if entries.get(tag, 0) >= base else base) for tag in (5, 6, 23)
    )
    libc = ctypes.CDLL(None)
    for row in range(imports, imports + entries.get(2, 0), 24):
        symbol = symbols + 24 * number(ctypes.c_uint32, row + 12)
        if ctypes.string_at(names + number(ctypes.c_uint32, symbol)) == DRAW:
            slot = base + long(row)
            spans = [[int(end, 16) for end in m[0].split("-")] for m in maps if "w" in m[1]]
            if any(start <= slot < end for start, end in spans):
                libc.srand(seed)
                ctypes.c_uint64.from_address(slot).value = ctypes.cast(
                    libc.rand, ctypes.c_void_p
                ).value
                return True
    return False


