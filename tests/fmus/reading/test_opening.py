"""FMU files that cannot be trusted, or not be run here: each is refused with one message, before anything runs.

Shows `fmus/reading/opening.py`, and with it `archive.py`, `library.py`, `needed_functions.py` and `recompile.py`, and
of the toolchain `function_library.py`.
"""

from __future__ import annotations

import gc
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu

from components.interfaces.problem import RequestError
from components.interfaces.quantity import Quantity
from components.interfaces.record import Variable
from fmus.reading import description, opening
from fmus.reading.archive import VALID_FMU, Archive
from fmus.reading.description import read_description
from fmus.reading.needed_functions import all_functions, needed_functions
from fmus.reading.opening import open_fmu
from fmus.toolchain.compiler import required_compiler
from fmus.toolchain.platform_names import binary_path, platform_tuple
from fmus.toolchain.version import Version
from fmus.unit_interface import Interface
from fmus.units.make import fmu_unit
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import C, copied, description2, description3, entries, functions, library, pack, scalar

TEXT = {
    2: description2([scalar("y", 101, "output")], ['<Unknown index="1"/>'], initial=['<Unknown index="1"/>']),
    3: description3(
        ['<Float64 name="y" valueReference="101" causality="output"/>'],
        ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>'],
    ),
}
HERE = platform_tuple()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("fmus")
    for version in (2, 3):
        binary = library(made / str(version), Version(version), f'#include "echo{version}.c"')
        pack(made / f"good{version}.fmu", Version(version), TEXT[version], binary)
    return made


@pytest.fixture(params=[2, 3], ids=["fmi2", "fmi3"])
def version(request):
    return request.param


@pytest.fixture
def good(folder, version):
    return folder / f"good{version}.fmu"


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """A user's cache of its own for each test."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


def changed(good, tmp_path, version, text=None, binary=None):
    files = {} if text is None else {"modelDescription.xml": text.encode()}
    if binary is not None:
        files[binary_path(Version(version), "m")] = binary.read_bytes() if hasattr(binary, "read_bytes") else binary
    return copied(good, tmp_path / "m.fmu", files)


def refusal(path):
    """What is said of an FMU, by opening it or by making a unit of it; nothing of it stays behind."""
    with pytest.raises(RequestError) as error:
        fmu_unit("m", open_fmu(path)).close()
    return str(error.value).replace(f"{path.parent}/", "")


def rows(path):
    return simulate(System({"m": Fmu(path)}, {}), h=0.1, until=0.1)


def test_a_good_fmu_runs_without_a_remark(good):
    assert open_fmu(good).remarks == ()
    assert rows(good)["m.y"].tolist() == [0.0, 0.0]


def test_files_that_are_no_fmus_are_refused(tmp_path):
    assert refusal(tmp_path / "none.fmu") == f"none.fmu: found no such file; valid: {VALID_FMU}"
    with zipfile.ZipFile(tmp_path / "other.fmu", "w") as archive:
        archive.writestr("readme.txt", "hello")
    assert refusal(tmp_path / "other.fmu") == (
        f"other.fmu: found an archive without modelDescription.xml; valid: {VALID_FMU}"
    )


def test_damaged_and_cut_archives_are_refused_when_they_are_opened(good, tmp_path):
    content = bytearray(good.read_bytes())
    path = tmp_path / "m.fmu"
    at = content.index(b"binaries/") + 200
    content[at : at + 50] = bytes(50)
    path.write_bytes(bytes(content))
    assert refusal(path).startswith("m.fmu: found a corrupt archive (")
    path.write_bytes(good.read_bytes()[:-200])
    assert refusal(path) == f"m.fmu: found a file that is no zip archive; valid: {VALID_FMU}"


def test_entries_that_would_leave_the_folder_are_refused(good, tmp_path):
    path = copied(good, tmp_path / "m.fmu", {"../evil.txt": b"x"})
    assert refusal(path) == f"m.fmu: found an entry that would leave the folder, ../evil.txt; valid: {VALID_FMU}"


def test_a_wrong_token_is_told_with_what_the_fmu_says(good, tmp_path, version):
    said = {2: "found other, 5 letter(s); valid: g", 3: 'the token is "g"'}[version]
    text = TEXT[version].replace('guid="g"', 'guid="other"').replace('Token="g"', 'Token="other"')
    name = {2: "GUID", 3: "token"}[version]
    assert refusal(changed(good, tmp_path, version, text)) == (
        f"m.fmu: found a library that refuses to make an instance ({said}); valid: a library that takes the {name}"
        " `other` of its modelDescription.xml. Export the FMU again."
    )


def test_somebody_who_simulates_with_fmpy_meanwhile_does_not_take_our_messages(good, tmp_path, version):
    """FMPy's library for the messages of FMI 2.0 knows one receiver: it called what was no longer there."""
    theirs = []
    path = changed(good, tmp_path, version, TEXT[version].replace('="g"', '="other"'))
    before = refusal(path)
    simulate_fmu(str(good), stop_time=0.1, output_interval=0.1, logger=lambda *said: theirs.append(said))
    gc.collect()
    assert refusal(path) == before
    assert theirs == []


def test_a_refusal_without_a_reason_is_told_as_one(good, tmp_path, version):
    name = {2: "fmi2Instantiate", 3: "fmi3InstantiateCoSimulation"}[version]
    binary = library(tmp_path, Version(version), f"#include <stddef.h>\nvoid *{name}() {{ return NULL; }}")
    text = refusal(changed(good, tmp_path, version, binary=binary))
    assert text.startswith("m.fmu: found a library that refuses to make an instance, and does not say why; valid:")


def test_a_library_is_unloaded_with_its_unit_and_where_it_is_refused(good, tmp_path, version):
    def in_memory():
        return Path("/proc/self/maps").read_text().count("/macrostep_")

    before = in_memory()
    unit = fmu_unit("m", open_fmu(good))
    assert in_memory() > before
    unit.close()
    assert in_memory() == before
    refusal(changed(good, tmp_path, version, TEXT[version].replace('="g"', '="other"')))
    assert in_memory() == before


def test_what_is_no_library_is_refused(good, tmp_path, version):
    place = binary_path(Version(version), "m")
    assert refusal(changed(good, tmp_path, version, binary=b"\x7fELF nothing of the kind")) == (
        f"m.fmu, {place}: found a damaged library; valid: a shared library for {HERE}."
        " Ask its maker for a binary for this platform, or the sources."
    )


def test_a_pointer_of_git_lfs_says_how_to_fetch_the_file(good, tmp_path, version):
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 1\n"
    place = binary_path(Version(version), "m")
    assert refusal(changed(good, tmp_path, version, binary=pointer)) == (
        f"m.fmu, {place}: found a pointer of Git LFS instead of the file itself; valid: a shared library for {HERE}."
        " Fetch it with `git lfs pull`, and pack it again."
    )


def test_a_library_for_another_machine_is_refused_or_its_sources_are_compiled(good, tmp_path, version):
    place = binary_path(Version(version), "m")
    code = bytearray(entries(good)[place])
    code[18:20] = (183).to_bytes(2, "little")
    assert refusal(changed(good, tmp_path, version, binary=bytes(code))) == (
        f"m.fmu, {place}: found a library for aarch64-linux; valid: a shared library for {HERE}."
        " Ask its maker for a binary for this platform, or the sources."
    )
    path = copied(with_sources(good, tmp_path, version), tmp_path / "n.fmu", {place: bytes(code)})
    assert open_fmu(path).remarks == (
        f"no binary for {HERE} (a library for aarch64-linux in its place); compiled here from the sources inside",
    )
    assert len(rows(path)) == 2


def test_functions_that_are_missing_are_named(good, tmp_path, version):
    absent = [f"fmi{version}DoStep", f"fmi{version}Reset"]
    binary = library(tmp_path, Version(version), "", absent=absent)
    assert refusal(changed(good, tmp_path, version, binary=binary)) == (
        f"m.fmu, {binary_path(Version(version), 'm')}: found a library without fmi{version}DoStep;"
        f" valid: all functions of FMI {version}.0. Export the FMU again."
    )


def unneeded(version):
    """The functions that no Co-Simulation run calls of the FMU of these tests."""
    fmi = Version(version)
    needed = needed_functions(described(version))
    return [name for name in functions(fmi) if name not in needed]


def described(version):
    description = read_description(TEXT[version].encode(), "m.fmu", lenient=False)
    outputs = (Variable("y", Quantity("1", "y")),)
    interface = Interface("m", (), outputs, (), np.zeros((1, 0), dtype=bool), output_after_set=True, starts={})
    return Archive(Path("m.fmu"), Version(version), description.model, interface, {})


def only_what_is_needed(folder, version):
    """A library that exports the functions that a run calls, and no other."""
    keep = "; ".join(sorted(needed_functions(described(version))))
    (folder / "exports.map").write_text(f"{{ global: {keep}; local: *; }};")
    option = f"-Wl,--version-script={folder / 'exports.map'}"
    return library(folder, Version(version), f'#include "echo{version}.c"', option)


def test_functions_that_no_run_calls_may_be_absent(good, tmp_path, version):
    """Simulink R2024b and Dymola export of FMI 3.0 only what Co-Simulation needs; FMI 2.0 demands all functions."""
    path = changed(good, tmp_path, version, binary=only_what_is_needed(tmp_path, version))
    place = binary_path(Version(version), "m")
    lacking = [n for n in all_functions(described(version)) if n in unneeded(version)]
    some = ", ".join(lacking[:3]) + f" and {len(lacking) - 3} more"
    remark = f"{place}: lacks {len(lacking)} functions of FMI {version}.0 that no run calls ({some})"
    if version == 2:
        five = ", ".join(lacking[:5]) + f" and {len(lacking) - 5} more"
        assert refusal(path) == (
            f"m.fmu, {place}: found a library without {five}; valid: all functions of FMI 2.0."
            " Have the file corrected by its maker, or run it as it is with --lenient."
        )
    assert open_fmu(path, lenient=True).remarks == (remark,)
    source = Fmu(path, lenient=True)
    assert len(simulate(System({"m": source}, {}), h=0.1, until=0.1)) == 2


def prefixed(prefix, version):
    """The lines with which the header of the standard gives all functions a prefix; FMPy's does it for few."""
    names = functions(Version(version))
    lines = [f'#include "fmi{version}Functions.h"', *(f"#undef {n}\n#define {n} {prefix}{n}" for n in names)]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("prefix", ["m_", "other_"])
def test_names_of_functions_may_have_a_prefix(good, tmp_path, version, prefix):
    stubs = [f"-D{name}={prefix}{name}" for name in functions(Version(version))]
    binary = library(tmp_path, Version(version), f'{prefixed(prefix, version)}#include "echo{version}.c"', *stubs)
    path = changed(good, tmp_path, version, binary=binary)
    place = binary_path(Version(version), "m")
    assert open_fmu(path).remarks == (f"{place}: the names of its functions begin with `{prefix}`",)
    assert rows(path)["m.y"].tolist() == [0.0, 0.0]


def test_without_a_binary_and_sources_an_fmu_is_refused(good, tmp_path, version):
    own = binary_path(Version(version), "m")
    path = copied(good, tmp_path / "m.fmu", {own: None, "binaries/win64/m.dll": b"x", "binaries/win32/m.dll": b"x"})
    valid = f"valid: a binary for {HERE} ({own}), or the sources inside."
    remedy = "Ask its maker to export it with a binary for Linux, 64 bit, or with its sources."
    assert refusal(path) == (
        "m.fmu: found binaries for Windows, 32 bit (win32) and Windows, 64 bit (win64) only, and no sources;"
        f" {valid} {remedy}"
    )
    path = copied(good, tmp_path / "n.fmu", {own: None})
    assert refusal(path) == f"n.fmu: found no binary and no sources; {valid} {remedy}"


def test_a_library_under_another_name_is_named(good, tmp_path, version):
    own = binary_path(Version(version), "m")
    other = own.replace("/m.so", "/another.so")
    path = copied(good, tmp_path / "m.fmu", {own: None, other: entries(good)[own]})
    folder = own.rpartition("/")[0]
    assert refusal(path) == (
        f"m.fmu: found no m.so in {folder}, but another.so; valid: a library that has the name of the modelIdentifier,"
        " `m`. Have its maker correct the name of the library or the modelIdentifier."
    )


def test_libraries_of_the_system_that_are_missing_are_named(good, tmp_path, version):
    """All of them, with the packages that have them."""
    places = []
    for name in ("libnowhere.so.3", "libgfortran.so.4"):
        places.append(tmp_path / name)
        (tmp_path / "e.c").write_text("int nowhere(void) { return 1; }")
        command = [*required_compiler().command, "-shared", "-fPIC", str(tmp_path / "e.c"), f"-Wl,-soname,{name}"]
        subprocess.run([*command, "-o", str(places[-1])], check=True)
    needs = ["-Wl,--no-as-needed", *map(str, places)]
    binary = library(tmp_path / "c", Version(version), f'#include "echo{version}.c"', *needs)
    path = changed(good, tmp_path, version, binary=binary)
    place = binary_path(Version(version), "m")
    assert refusal(path) == (
        f"m.fmu, {place}: found a library that needs libnowhere.so.3, libgfortran.so.4, which are not on this machine;"
        f" valid: a shared library that {HERE} loads. Install them (Debian: apt-get install libgfortran4)."
    )
    beside = place.replace("m.so", "libnowhere.so.3")
    path = copied(path, tmp_path / "n.fmu", {beside: places[0].read_bytes()})
    assert "found a library that does not look for libnowhere.so.3 in its own folder;" in refusal(path)


def test_a_function_that_no_library_has_is_named(good, tmp_path, version):
    source = f'void nowhere(void);\nvoid unused(void) {{ nowhere(); }}\n#include "echo{version}.c"'
    path = changed(good, tmp_path, version, binary=library(tmp_path, Version(version), source, "-Wl,-z,now"))
    assert "found a library that uses `nowhere`, which no library has that it names;" in refusal(path)


BUILD = """<fmiBuildDescription fmiVersion="3.0"><BuildConfiguration modelIdentifier="m">
<SourceFileSet language="C99"><SourceFile name="m.c"/><SourceFile name="stubs.c"/>
<PreprocessorDefinition name="EXTRA" value="*(double *)room(i-&gt;slots + 1, 1, 8) = 7;"/>
<IncludeDirectory name="inside"/></SourceFileSet></BuildConfiguration></fmiBuildDescription>"""


def with_sources(good, tmp_path, version, source=None):
    """The FMU without its binary, with its sources; those of FMI 3.0 need a definition and a folder of their own."""
    listed = '<SourceFiles><File name="m.c"/><File name="stubs.c"/></SourceFiles>'
    text = TEXT[2].replace('modelIdentifier="m"/>', f'modelIdentifier="m">{listed}</CoSimulation>')
    files = {
        binary_path(Version(version), "m"): None,
        "sources/m.c": (source or f'#include "echo{version}.c"\n').encode(),
        "sources/stubs.c": (good.parent / str(version) / "stubs.c").read_bytes(),
        f"sources/{'' if version == 2 else 'inside/'}echo{version}.c": (C / f"echo{version}.c").read_bytes(),
        **(
            {"modelDescription.xml": text.encode()}
            if version == 2
            else {"sources/buildDescription.xml": BUILD.encode()}
        ),
    }
    return copied(good, tmp_path / "m.fmu", files)


def test_sources_are_compiled_where_there_is_no_binary_and_kept(good, tmp_path, version, cache):
    path = with_sources(good, tmp_path, version)
    assert open_fmu(path).remarks == (f"no binary for {HERE}; compiled here from the sources inside",)
    assert rows(path)["m.y"].tolist() == [0.0, 7.0 if version == 3 else 0.0]
    kept = list((cache / "macrostep" / "compiled").iterdir())
    assert len(kept) == 1
    made = kept[0].stat().st_mtime_ns
    assert rows(path)["m.y"].tolist() == [0.0, 7.0 if version == 3 else 0.0]
    assert kept[0].stat().st_mtime_ns == made


def test_a_cache_that_cannot_be_written_to_costs_time_only(good, tmp_path, version, cache):
    cache.write_text("no folder")
    assert len(rows(with_sources(good, tmp_path, version))) == 2


def test_a_source_file_that_is_declared_and_absent_is_named(good, tmp_path, version):
    path = copied(with_sources(good, tmp_path, version), tmp_path / "n.fmu", {"sources/stubs.c": None})
    assert refusal(path) == (
        f"n.fmu: found no binary for {HERE}, and no source file sources/stubs.c, which it declares; valid: all its"
        f" source files, or a binary for {HERE} ({binary_path(Version(version), 'm')})."
        " Ask its maker for a complete export."
    )


def test_sources_that_nothing_declares_are_compiled_all(folder, tmp_path):
    path = with_sources(folder / "good2.fmu", tmp_path, 2)
    path = copied(path, tmp_path / "n.fmu", {"modelDescription.xml": TEXT[2].encode(), "sources/echo2.c": None})
    path = copied(path, tmp_path / "o.fmu", {"sources/m.c": (C / "echo2.c").read_bytes()})
    assert open_fmu(path).remarks == (
        f"no binary for {HERE}; compiled here from m.c, stubs.c in its folder of sources, which it does not declare",
    )
    assert rows(path)["m.y"].tolist() == [0.0, 0.0]
    whole = (
        (C / "echo2.c").read_text()
        + """
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tol, fmi2Real t, fmi2Boolean e, fmi2Real s) {
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
"""
    )
    path = copied(path, tmp_path / "p.fmu", {"sources/all.c": whole.encode(), "sources/m.c": b"int x = ;"})
    assert "compiled here from all.c in its folder" in open_fmu(path).remarks[0]
    assert rows(path)["m.y"].tolist() == [0.0, 0.0]


def test_sources_whose_functions_have_a_prefix_run(good, tmp_path, version):
    path = with_sources(good, tmp_path, version, source=f'{prefixed("m_", version)}#include "echo{version}.c"\n')
    stubs = "".join(f"#define {name} m_{name}\n" for name in functions(Version(version))).encode()
    path = copied(path, tmp_path / "n.fmu", {"sources/stubs.c": stubs + entries(path)["sources/stubs.c"]})
    assert len(rows(path)) == 2


def test_sources_that_do_not_compile_are_told_with_the_compilers_words(good, tmp_path, version):
    text = refusal(with_sources(good, tmp_path, version, source="int x = ;"))
    assert text.startswith(f"m.fmu: found no binary for {HERE}, and sources that do not compile (m.c:1:9: error:")
    assert text.endswith("; valid: sources that a C compiler takes. Have it built for this platform.")


def test_without_a_compiler_sources_are_refused(good, tmp_path, version, monkeypatch):
    path = with_sources(good, tmp_path, version)
    monkeypatch.setenv("CC", "no-such-compiler")
    assert refusal(path).startswith("building FMUs: found CC=no-such-compiler, which cannot be run; valid:")


def test_our_own_fmus_compile_from_their_sources_to_the_same_numbers(built_fmus, tmp_path, version):
    original = built_fmus / f"fmi{version}" / "ramp_traffic.fmu"
    path = copied(original, tmp_path / "m.fmu", {binary_path(Version(version), "ramp_traffic"): None})
    held = {f"m.{v.name}": 0.0 for v in open_fmu(path).interface.inputs}
    runs = [simulate(System({"m": Fmu(p)}, {}, held=held), h=0.1, until=2.0) for p in (original, path)]
    assert runs[0].equals(runs[1])


@pytest.mark.parametrize(
    ("status", "words"),
    [
        ("Discard", "discarded the step"),
        ("Error", "returned an error"),
        ("Fatal", "returned a fatal error"),
    ],
)
def test_steps_that_fail_end_the_run_with_all_rows(good, tmp_path, version, status, words):
    source = f'#define STATUS (t > 0.25 ? fmi{version}{status} : fmi{version}OK)\n#include "echo{version}.c"'
    path = changed(good, tmp_path, version, binary=library(tmp_path, Version(version), source))
    with Simulation(System({"m": Fmu(path)}, {}), h=0.1, until=1.0) as simulation:
        with pytest.raises(SimulationError) as error:
            simulation.run()
        assert len(simulation.frame()) == 4
    assert str(error.value) == f"tick 3 (t = 0.3 s), unit `m`: `fmi{version}DoStep` {words}"


CHATTY = """
#include "fmi2Functions.h"
#include <string.h>
static fmi2Boolean wanted;
static fmi2CallbackLogger say;
static fmi2Status discard(double t) {
    if (wanted && t > 0.25) say(0, "m", fmi2Discard, "logStatusDiscard", "no root beyond %.2f s", 0.25);
    return t > 0.25 ? fmi2Discard : fmi2OK;
}
#define STATUS discard(t)
#define EXTRA say = f->logger; wanted = l;
#include "echo2.c"
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[]) {
    for (size_t k = 0; k < n; k++) {
        if (strcmp(names[k], "logStatusDiscard")) return fmi2Error;
        wanted = on;
    }
    return fmi2OK;
}
"""


def test_an_fmi2_unit_that_logs_when_it_is_asked_to_says_why_a_step_failed(tmp_path):
    categories = '<LogCategories><Category name="logEvents"/><Category name="logStatusDiscard"/></LogCategories>'
    text = description2([scalar("y", 101, "output")], ['<Unknown index="1"/>'], before=categories)
    path = pack(tmp_path / "m.fmu", Version.FMI2, text, library(tmp_path / "c", Version.FMI2, CHATTY))
    with pytest.raises(SimulationError) as error:
        simulate(System({"m": Fmu(path)}, {}), h=0.1, until=1.0)
    assert str(error.value) == "tick 3 (t = 0.3 s), unit `m`: `fmi2DoStep` discarded the step: no root beyond 0.25 s"


def test_outputs_that_are_no_numbers_end_the_run(good, tmp_path, version):
    lines = {2: "i->r[1] = 0.0 / 0.0;", 3: "*(double *)room(i->slots + 1, 1, 8) = 0.0 / 0.0;"}
    source = f'#define EXTRA {lines[version]}\n#include "echo{version}.c"'
    path = changed(good, tmp_path, version, binary=library(tmp_path, Version(version), source))
    reader = [scalar("u", 1, "input", of_start="0"), scalar("y", 101, "output")]
    unknown = ['<Unknown index="2" dependencies=""/>']
    text = description2(reader, unknown, initial=unknown)
    other = pack(tmp_path / "other.fmu", Version.FMI2, text, library(tmp_path, Version.FMI2, '#include "echo2.c"'))
    system = System({"m": Fmu(path), "n": Fmu(other)}, {"n.u": "m.y"})
    with pytest.raises(SimulationError, match="the signal `m.y` is -?nan, which `n.u` would receive"):
        simulate(system, h=0.1, until=0.1)
    assert rows(path)["m.y"].isna().any()


def test_what_an_fmu_writes_does_not_disturb_a_run(good, tmp_path, version):
    source = f'#define EXTRA printf("hello from C\\n");\n#include "echo{version}.c"'
    path = changed(good, tmp_path, version, binary=library(tmp_path, Version(version), source))
    for in_process in (True, False):
        program = (
            "from orchestrator.stepping.whole_run import simulate\n"
            "from orchestrator.system.source import Fmu\nfrom orchestrator.system.system import System\n"
            f"units = {{'m': Fmu({str(path)!r}, in_process={in_process})}}\n"
            "print(len(simulate(System(units, {}), h=0.1, until=0.5)))"
        )
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
        assert sorted((done.stdout + done.stderr).split()) == sorted(["6", "hello", "from", "C"])
        assert "6" in done.stdout


def test_an_fmu_that_needs_its_tool_says_so(good, tmp_path, version):
    text = TEXT[version].replace('modelIdentifier="m"', 'modelIdentifier="m" needsExecutionTool="true"')
    assert open_fmu(changed(good, tmp_path, version, text)).remarks == ("needs the tool that made it to be installed",)


@pytest.mark.foreign
def test_an_fmu_that_a_process_holds_once_is_not_used_twice(good, tmp_path, version):
    once = 'modelIdentifier="m" canBeInstantiatedOnlyOncePerProcess="true"'
    path = changed(good, tmp_path, version, TEXT[version].replace('modelIdentifier="m"', once))
    assert len(rows(path)) == 2
    assert len(simulate(System({"a": Fmu(path), "b": Fmu(path)}, {}), h=0.1, until=0.1)) == 2
    here = Fmu(path, in_process=True)
    assert len(simulate(System({"a": here, "b": Fmu(path)}, {}), h=0.1, until=0.1)) == 2
    with pytest.raises(RequestError) as error:
        System({"a": here, "b": here}, {})
    assert str(error.value) == (
        f"unit `b`: found {path}, which `a` runs too; valid: an FMU that can be instantiated more than once per"
        " process. Run one of them in a process of its own."
    )


def test_arrays_that_would_fill_the_memory_are_refused(folder, tmp_path):
    y = '<Float64 name="y" valueReference="101" causality="output"'
    text = TEXT[3].replace(f"{y}/>", f'{y}><Dimension start="4000000000"/></Float64>')
    assert refusal(changed(folder / "good3.fmu", tmp_path, 3, text)) == (
        "m.fmu, modelDescription.xml, line 7: found a variable that cannot be understood (`y` with 4000000000"
        " elements, more than 10000000); valid: what FMI allows"
    )


def test_platform_names_of_fmi3_are_taken_for_fmi2_too(folder, tmp_path):
    good, own, other = folder / "good2.fmu", binary_path(Version.FMI2, "m"), binary_path(Version.FMI3, "m")
    assert own != other
    path = copied(good, tmp_path / "m.fmu", {own: None, other: entries(good)[own]})
    assert open_fmu(path).remarks == ()
    assert rows(path)["m.y"].tolist() == [0.0, 0.0]


def test_lenient_readers_run_what_breaks_a_rule(good, tmp_path, version):
    text = TEXT[version].replace('modelName="m"', 'modelName="m" maker="me"')
    path = changed(good, tmp_path, version, text)
    assert "attribute 'maker'" in refusal(path)
    source = Fmu(path, lenient=True)
    assert len(simulate(System({"m": source}, {}), h=0.1, until=0.1)) == 2
    assert "attribute 'maker'" in source.archive.remarks[0]


@pytest.mark.parametrize("attribute", ["startTime", "stopTime", "stepSize", "tolerance"])
@pytest.mark.parametrize("value", ["low", "1+0", "²", "INF", "1e999"])
def test_times_of_an_experiment_are_numbers(tmp_path, attribute, value):
    text = description2(
        [scalar("y", 1, "output")], ['<Unknown index="1"/>'], before=f'<DefaultExperiment {attribute}="{value}"/>'
    )
    path = pack(tmp_path / "m.fmu", Version.FMI2, text, None)
    with pytest.raises(RequestError) as error:
        open_fmu(path, lenient=True)
    assert str(error.value).startswith(f"{path}, modelDescription.xml, line 4: found something that cannot be read (")
    assert str(error.value).endswith("; valid: times in seconds, as numbers")


def test_a_clock_that_is_none_is_refused_with_its_line(tmp_path):
    clock = (
        '<Clock name="c" valueReference="1" causality="input" intervalVariability="constant" intervalDecimal="0,1"/>'
    )
    path = pack(tmp_path / "m.fmu", Version.FMI3, description3([clock]), None)
    with pytest.raises(RequestError) as error:
        open_fmu(path, lenient=True)
    assert str(error.value) == (
        f"{path}, modelDescription.xml, line 7: found a wrong clock (ValueError: could not convert string to"
        " float: '0,1');"
        " valid: a clock as FMI 3.0 allows it"
    )


def test_outputs_and_inputs_whose_pairs_would_fill_the_memory_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(opening, "LARGEST_FEEDTHROUGH", 5)
    names = [(f"{kind[0]}{k}", kind) for kind in ("input", "output") for k in range(3)]
    text = description2([scalar(n, k, kind, of_start="0") for k, (n, kind) in enumerate(names)])
    path = pack(tmp_path / "m.fmu", Version.FMI2, text.replace('start="0"', ""), None)
    with pytest.raises(RequestError, match="3 outputs and 3 inputs, which are 9 pairs; valid: at most 5 pairs"):
        open_fmu(path, lenient=True)


def test_very_many_variables_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(description, "MOST_VARIABLES", 1)
    path = pack(tmp_path / "m.fmu", Version.FMI2, description2([scalar(n, 1, "input") for n in "ab"]), None)
    with pytest.raises(RequestError, match="found 2 variables; valid: at most 1. Export a smaller part of the model."):
        open_fmu(path)
