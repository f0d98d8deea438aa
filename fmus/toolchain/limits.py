"""The limits of what is taken from others: sizes, counts and times, each with what happens beyond it."""

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
LARGEST_OUTPUT: Final = 64 * 1024
"""[byte] What a child process may print; the rest is left out."""
LONGEST_MESSAGE: Final = 400
"""[characters] What is kept of one message of an FMU; the rest is left out."""
MOST_MESSAGES: Final = 20
"""The messages of an FMU that are kept, the last ones; an FMU may log without end."""
MOST_TOLD: Final = 5
"""The messages of an FMU that an error shows."""
MOST_REMARKS: Final = 20
"""The remarks on one unit; the rest is left out."""
