"""From measurements to materials: files of instruments, pokes by robots, and the virtual experiment."""
