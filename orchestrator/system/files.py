"""Files that people write: read as TOML, checked as a model, with everything that is wrong told at once."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from components.interfaces.problem import refuse


def read_toml(path: Path) -> dict[str, Any]:
    """A TOML file. Raises `RequestError` with the line when it cannot be read."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise refuse(str(path), f"a file that cannot be read ({error})", "a TOML file") from error
    except tomllib.TOMLDecodeError as error:
        raise refuse(str(path), f"text that is no TOML ({error})", "a TOML file") from error
