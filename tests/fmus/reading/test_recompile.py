"""Sources of FMUs are foreign: what they are called, how they want to be compiled, and how long that takes.

Shows `recompile.py` and, of the library, what is told of it.
"""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from fmus.reading import recompile
from fmus.reading.library import compile_beforehand
from fmus.reading.opening import open_fmu
from fmus.toolchain.limited_command import CommandLimits
from fmus.toolchain.platform_names import platform_tuple
from fmus.toolchain.version import Version
from tests.fmus.foreign import description2, description3, pack, scalar

VARIABLES = {2: [scalar("y", 1, "output")], 3: ['<Float64 name="y" valueReference="1" causality="output"/>']}
STRUCTURE = {2: ['<Unknown index="1"/>'], 3: ['<Output valueReference="1"/>']}
NO_BINARY = f"no binary for {platform_tuple()}"


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """A user's cache of its own for each test."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


class Told:
    """Receives reports, and says what compiling a model has made of them."""

    def __init__(self):
        self.lines = []

    def now(self, text):
        self.lines.append(f"now {text}")

    def done(self, text):
        self.lines.append(text)


def fmu2(folder, source, identifier="m"):
    interface = f'<CoSimulation modelIdentifier="{identifier}"/>'
    text = description2(VARIABLES[2], STRUCTURE[2], interface=interface)
    return pack(folder / "theirs.fmu", Version.FMI2, text, None, **{"sources__all.c": source})


def fmu3(folder, build, source="int x;", **files):
    text = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0"><BuildConfiguration modelIdentifier="m">{build}</BuildConfiguration>
</fmiBuildDescription>"""
    description = description3(VARIABLES[3], STRUCTURE[3])
    given = {"sources__buildDescription.xml": text, "sources__m.c": source, **files}
    return pack(folder / "theirs.fmu", Version.FMI3, description, None, **given)


def refusal(folder, path):
    with pytest.raises(RequestError) as error:
        compile_beforehand(open_fmu(path))
    return str(error.value).replace(f"{folder}/", "")


@pytest.mark.parametrize("identifier", ["../../x", "/x", "a/b", "a\\b", "..", "x" * 300])
def test_a_model_identifier_is_the_name_of_a_file(tmp_path, identifier):
    shown = identifier if len(identifier) < 100 else f"{identifier[:80]}... (300 characters)"
    path = fmu2(tmp_path / "a", "int x;", identifier)
    with pytest.raises(RequestError) as error:
        open_fmu(path, lenient=True)
    assert str(error.value) == (
        f"{path}, modelDescription.xml, line 3: found the modelIdentifier `{shown}`; valid: the name of the"
        " library: a name"
        " without folders, of letters, digits and other printable characters"
    )
    assert [p.name for p in tmp_path.iterdir()] == ["a"]


def test_a_line_says_before_it_happens_that_sources_are_compiled(tmp_path):
    path, told = fmu2(tmp_path, "int x;"), Told()
    compile_beforehand(open_fmu(path), told)
    assert told.lines == [f"compiling C of {path} for this platform, for at most 120 s"]
    compile_beforehand(open_fmu(path), told)
    assert len(told.lines) == 1  # it is kept


def test_sources_that_compile_for_ever_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(recompile, "COMPILING_TIME", 1.0)
    monkeypatch.setattr(recompile, "_LIMITS", CommandLimits(1.0, 4 * 2**30, 2**28))
    twice = '#if __INCLUDE_LEVEL__ < 40\n#include "all.c"\n#include "all.c"\n#endif\n'
    assert refusal(tmp_path, fmu2(tmp_path, twice)) == (
        f"theirs.fmu: found {NO_BINARY}, and sources that do not compile within 1 s;"
        " valid: sources that a C compiler takes. Have it built for this platform."
    )


def test_sources_that_take_all_memory_or_disk_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(recompile, "_LIMITS", CommandLimits(60.0, 2**28, 2**20))
    for source in ('#include "/dev/zero"\n', "char x[1 << 24] = {1};\n"):
        assert refusal(tmp_path, fmu2(tmp_path, source)).startswith(
            f"theirs.fmu: found {NO_BINARY}, and sources that do not compile ("
        )


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("../../x.c", "would leave the folder"),
        ("/etc/x.c", "would leave the folder"),
        ("..\\x.c", "would leave the folder"),
        ("d/" * 100 + "x.c", "has more than 64 folders inside each other"),
    ],
)
def test_source_files_outside_their_folder_are_refused(tmp_path, name, reason):
    path = fmu3(tmp_path, f'<SourceFileSet><SourceFile name="{name}"/></SourceFileSet>')
    shown = name if len(name) < 80 else f"{name[:80]}... ({len(name)} characters)"
    assert refusal(tmp_path, path) == (
        f"theirs.fmu: found the source file `{shown}`, which {reason}; valid: the path of a file in the folder"
        " `sources`"
    )


def test_options_that_can_do_harm_are_left_out_and_told(tmp_path):
    build = '<SourceFileSet compilerOptions="-O1 -fplugin=x.so -o ../../y.c @z -DA=1 -Wl,-Map=m">'
    build += '<SourceFile name="m.c"/><PreprocessorDefinition name="B" value="2"/><IncludeDirectory name="/etc"/>'
    build += '</SourceFileSet><Library name="m" external="true"/><Library name="../x" external="true"/>'
    path = fmu3(tmp_path / "a", build, "int x[A == 1 && B == 2 ? 1 : -1];")
    archive = open_fmu(path)
    assert archive.remarks[-1] == (
        f"{NO_BINARY}; compiled here from the sources inside, without -fplugin=x.so, -o, ../../y.c and 4 more,"
        " which can"
        " do harm"
    )
    compile_beforehand(archive)
    assert {p.name for p in tmp_path.iterdir()} == {"a", "cache"}
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_a_source_file_may_begin_like_an_option(tmp_path):
    build = '<SourceFileSet><SourceFile name="-oy.c"/><SourceFile name="@x.c"/></SourceFileSet>'
    path = fmu3(tmp_path, build, **{"sources__-oy.c": "int a;", "sources__@x.c": "int b;"})
    compile_beforehand(open_fmu(path))


def test_a_quotation_mark_that_is_left_open_is_told(tmp_path):
    path = fmu3(tmp_path, """<SourceFileSet compilerOptions="-DX='"><SourceFile name="m.c"/></SourceFileSet>""")
    assert refusal(tmp_path, path) == (
        "theirs.fmu, sources/buildDescription.xml: found compilerOptions `-DX='`; valid: options with closed"
        " quotation marks"
    )
