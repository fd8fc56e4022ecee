"""From measurements to materials: files of instruments, tables of pokes, measurement by hand, and a virtual press."""
