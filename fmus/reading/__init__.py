"""An FMU file becomes a description: unpacked, checked, understood."""
