"""What building and reading FMUs share: compiler, archives, platforms, versions of FMI, and FMPy."""
