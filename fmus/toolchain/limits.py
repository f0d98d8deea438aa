"""All limits of what is taken from others: sizes, depths, counts, memory and time.

A file beyond one of them is refused in words before it takes what it asks for. Each limit lies well above what the
largest models of today need. `fmus/README.md` has them as a table.
"""

from __future__ import annotations

from typing import Final

PATIENCE: Final = 30.0
"""[s] The time that one call of an FMU in a process of its own may take by default; then its process is ended."""
LARGEST_ANSWER: Final = 256 * 1024**2
"""[byte] One message of a child process; a larger one is not sent, and what announces a larger one is no message."""
LARGEST_BINARY: Final = 64 * 1024**2
"""[byte] One value of type Binary of an FMU; a larger one ends the run."""
LARGEST_STRING: Final = 1024**2
"""[byte] One value of type String of an FMU; a larger one ends the run."""
LARGEST_OUTPUT: Final = 16 * 1024
"""[byte] What a child process may print; the rest is left out."""
LONGEST_MESSAGE: Final = 400
"""[characters] What is kept of one message of an FMU; the rest is left out."""
MOST_MESSAGES: Final = 20
"""The messages of an FMU that are kept, the last ones; an FMU may log without end."""
MOST_TOLD: Final = 5
"""The messages of an FMU that an error shows."""
MOST_REMARKS: Final = 20
"""The remarks on one unit; the rest is left out."""
MOST_ENTRIES: Final = 100_000
"""The most files and folders in one archive."""
LARGEST_ARCHIVE: Final = 8 * 2**30
"""[byte] The size of all files of an archive together, and of all archives inside an SSP."""
SUSPICIOUS_SIZE: Final = 256 * 2**20
"""[byte] Files that have more together, and more than `LARGEST_RATIO` times the size of the archive, are a zip bomb."""
SUSPICIOUS_FILE: Final = 4 * 2**20
"""[byte] One file that is read into memory, has more than this, and more than `LARGEST_RATIO` times its packed size."""
LARGEST_RATIO: Final = 200
LARGEST_FILE_READ: Final = 2**30
"""[byte] The largest file of an archive that is read into memory: a description or a library."""
LONGEST_PATH: Final = 1000
"""The most characters in the path of a file inside an archive."""
LONGEST_FILE_NAME: Final = 255
"""[byte] The longest name of a file or folder, as most file systems have it."""
DEEPEST_PATH: Final = 64
"""The most folders inside each other."""
LARGEST_CACHE: Final = 2 * 2**30
"""[byte] What is kept of unpacked FMUs in the user's cache; the ones that were used longest ago go first."""
MOST_KEPT: Final = 256
"""The most FMUs that are kept there."""

LARGEST_XML: Final = 512 * 2**20
"""[byte] More than the longest description has: an array may have 10 million elements."""
LARGEST_TREE: Final = 512 * 2**20
"""[byte] The memory that the elements and attributes of a document may take, as estimated before it is read."""
DEEPEST_XML: Final = 256
"""The most elements inside each other."""
MOST_BREACHES: Final = 1000
"""The breaches of a schema after which a large document is not validated further."""

MOST_VARIABLES: Final = 250_000
"""The most variables of an FMU; each takes about 5 kB while it is read."""
LARGEST_ARRAY: Final = 10_000_000
"""The most elements of one variable; more would fill the memory before anything runs."""
MOST_ELEMENTS: Final = 20_000_000
"""The most elements of all variables of an FMU together."""
MOST_DIMENSIONS: Final = 32
"""The most dimensions of an array; NumPy has no more than 64."""
LARGEST_FEEDTHROUGH: Final = 2**28
"""The most pairs of an output and an input of an FMU, of which one may depend on the other."""

MOST_SYSTEMS: Final = 1000
"""The most systems that an SSP takes from other files or from other places in its own, each counted whenever it is
used: what is used ten times in what is used ten times is there a hundred times."""
MOST_SYSTEM_ELEMENTS: Final = 100_000
"""The most components and systems in an SSP, in all systems together."""
DEEPEST_SYSTEMS: Final = 50
"""The most systems from other files inside each other."""
LONGEST_UNIT_NAME: Final = 100
"""The most characters of the name of a unit or a system that becomes the name of a file."""

COMPILING_TIME: Final = 120.0
"""[s] The time that the compilation of the sources of an FMU may take."""
COMPILING_MEMORY: Final = 4 * 2**30
"""[byte] The memory of each process of the compiler."""
COMPILING_OUTPUT: Final = 256 * 2**20
"""[byte] The largest file that the compiler may write."""
FLATTENING_TIME: Final = 120.0
"""[s] The time in which rumoca has to flatten a Modelica model."""
FLATTENING_MEMORY: Final = 4 * 2**30
"""[byte] The memory of the process that does so."""
LARGEST_MODELICA: Final = 16 * 2**20
"""[byte] The longest Modelica file."""
MOST_UNKNOWNS: Final = 10_000
"""The most elements of all variables of a Modelica model, and the most equations."""
LIBRARY_TIME: Final = 120.0
"""[s] The time in which pyarrow or Rerun has to read a file in a process of its own."""
LIBRARY_MEMORY: Final = 16 * 1024**3
"""[byte] The address space of that process."""
